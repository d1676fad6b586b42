//! Stretches of track at which an effect acts.

/// Share of a stretch `[start_m, start_m + length_m]` of track that acts at `position_m`, 0 to 1, with smooth edges.
pub fn window_share(position_m: f64, start_m: f64, length_m: f64, edge_m: f64) -> f64 {
    let rise = |x: f64| 0.5 * (1.0 + (2.0 * x / edge_m).tanh());
    rise(position_m - start_m) * rise(start_m + length_m - position_m)
}
