#[path = "../tests/support/mod.rs"]
mod support;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let root = support::shared().unwrap();
    let folder = root.join(&a[1]);
    let vehicle = support::vehicle(&folder);
    let config = railgrip_filter::EstimatorConfig {
        filter: a.get(6).cloned().unwrap_or("default".into()),
        ..Default::default()
    };
    let (t0, t1, every): (f64, f64, usize) =
        (a[3].parse().unwrap(), a[4].parse().unwrap(), a[5].parse().unwrap());
    for run in support::runs(&folder) {
        if run.name != a[2] {
            continue;
        }
        let out = support::estimate(&config, &vehicle, &run.inputs);
        for i in (0..out.len()).step_by(every) {
            let (o, t, n) = (&out[i], &run.truth[i], &run.inputs[i]);
            if o.time_s < t0 || o.time_s > t1 {
                continue;
            }
            println!(
                "{:6.2} v {:6.2} F {:6.0} {:6.0} slip {:6.3} {:6.3} muw {:7.4} err {:7.4} sd {:.4} f {:7.4}/{:7.4} sd {:.4} r {:7.4}/{:7.4} sd {:.4} | b {:.4}/{:.4} sd {:.4} {:.4}/{:.4} sd {:.4} mean sd {:.4} | nis {:5.2} sl {} ob {} rej {} rank {}",
                o.time_s,
                o.v_m_s,
                n.pressing_force_n[0],
                n.pressing_force_n[1],
                o.slip[0] * o.v_m_s,
                o.slip[1] * o.v_m_s,
                o.mu_w,
                o.mu_w - t.mu_w,
                o.mu_w_sigma,
                o.mu_w_wheelset[0],
                t.mu_w_wheelset[0],
                o.mu_w_wheelset_sigma[0],
                o.mu_w_wheelset[1],
                t.mu_w_wheelset[1],
                o.mu_w_wheelset_sigma[1],
                o.mu_b[0],
                t.mu_b[0],
                o.mu_b_sigma[0],
                o.mu_b[1],
                t.mu_b[1],
                o.mu_b_sigma[1],
                o.mu_b_mean_sigma,
                o.nis,
                o.sliding,
                o.observable,
                o.rejected,
                o.observability_rank
            );
        }
        return;
    }
}
