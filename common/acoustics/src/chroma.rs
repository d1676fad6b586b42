//! Chroma: energy by pitch class, on a scale tuned to the signal itself.

use crate::{BINS, FRAME, SAMPLE_RATE_HZ, bin_frequency_hz};

/// Pitch classes.
const CLASSES: usize = 12;

/// Range in which peaks count for the tuning, Hz.
const PEAK_RANGE_HZ: std::ops::Range<f64> = 150.0..4000.0;

/// Peaks below this share of their frame's largest value do not count.
const PEAK_THRESHOLD: f64 = 0.1;

/// Mean over frames and pitch classes of the chroma, each frame relative to its strongest class.
pub(crate) fn mean_chroma(magnitudes: &[Vec<f64>]) -> f64 {
    let power: Vec<Vec<f64>> = magnitudes.iter().map(|frame| frame.iter().map(|m| m * m).collect()).collect();
    let filters = filter_bank(tuning(&power));
    let mut total = 0.0;
    for frame in &power {
        let mut classes = [0.0; CLASSES];
        for (class, filter) in classes.iter_mut().zip(&filters) {
            *class = filter.iter().zip(frame).map(|(weight, value)| weight * value).sum();
        }
        let strongest = classes.iter().copied().fold(0.0, f64::max);
        let scale = if strongest > f64::from(f32::MIN_POSITIVE) { strongest } else { 1.0 };
        total += classes.iter().sum::<f64>() / scale;
    }
    total / (CLASSES * power.len()) as f64
}

/// Octaves of a frequency above 27.5 Hz, the scale shifted by `tuning` semitones.
fn octaves(hz: f64, tuning: f64) -> f64 {
    (hz / (27.5 * (tuning / CLASSES as f64).exp2())).log2()
}

/// Gaussian bumps around each pitch class, weighted towards the middle octaves, one row a class (C first).
fn filter_bank(tuning: f64) -> Vec<Vec<f64>> {
    let classes = CLASSES as f64;
    // Position of each bin in semitones; DC has none and is put one and a half octaves below the first bin.
    let mut semitones: Vec<f64> =
        (0..=BINS).map(|bin| classes * octaves(bin_frequency_hz(bin), tuning)).collect();
    semitones[0] = semitones[1] - 1.5 * classes;
    let mut filters = vec![vec![0.0; BINS]; CLASSES];
    for bin in 0..BINS {
        let width = (semitones[bin + 1] - semitones[bin]).max(1.0);
        let mut column = [0.0; CLASSES];
        for (class, weight) in column.iter_mut().enumerate() {
            let half = classes / 2.0;
            let distance = (semitones[bin] - class as f64 + half).rem_euclid(classes) - half;
            *weight = (-0.5 * (2.0 * distance / width).powi(2)).exp();
        }
        let norm = column.iter().map(|w| w * w).sum::<f64>().sqrt();
        let octave_weight = (-0.5 * ((semitones[bin] / classes - 5.0) / 2.0).powi(2)).exp();
        for (class, weight) in column.iter().enumerate() {
            // The scale above begins at A; C is three semitones on.
            filters[(class + CLASSES - 3) % CLASSES][bin] = weight / norm * octave_weight;
        }
    }
    filters
}

/// Offset of the signal's peaks from the equal-tempered scale, semitones, the most frequent hundredth.
fn tuning(power: &[Vec<f64>]) -> f64 {
    let peaks: Vec<(f64, f64)> = power.iter().flat_map(|frame| frame_peaks(frame)).collect();
    if peaks.is_empty() {
        return 0.0;
    }
    let mut levels: Vec<f64> = peaks.iter().map(|peak| peak.1).collect();
    levels.sort_by(f64::total_cmp);
    let middle = levels.len() / 2;
    let median =
        if levels.len() % 2 == 1 { levels[middle] } else { 0.5 * (levels[middle - 1] + levels[middle]) };
    let mut counts = [0_u32; 100];
    for (hz, _) in peaks.iter().filter(|peak| peak.1 >= median) {
        let residual = (CLASSES as f64 * octaves(*hz, 0.0)).rem_euclid(1.0);
        let centred = if residual >= 0.5 { residual - 1.0 } else { residual };
        counts[(((centred + 0.5) * 100.0) as usize).min(99)] += 1;
    }
    let most = counts.iter().max().copied().unwrap_or(0);
    counts.iter().position(|&count| count == most).map_or(0.0, |bin| bin as f64 / 100.0 - 0.5)
}

/// Frequency, Hz, and level of a frame's peaks, refined by a parabola through three bins.
fn frame_peaks(frame: &[f64]) -> Vec<(f64, f64)> {
    let threshold = PEAK_THRESHOLD * frame.iter().copied().fold(0.0, f64::max);
    let kept = |bin: usize| if frame[bin] > threshold { frame[bin] } else { 0.0 };
    let is_peak = |&bin: &usize| {
        PEAK_RANGE_HZ.contains(&bin_frequency_hz(bin))
            && kept(bin) > kept(bin - 1)
            && kept(bin) >= kept(bin + 1)
    };
    (1..BINS - 1)
        .filter(is_peak)
        .map(|bin| {
            let slope = 0.5 * (frame[bin + 1] - frame[bin - 1]);
            let bend = frame[bin + 1] + frame[bin - 1] - 2.0 * frame[bin];
            let shift = if slope.abs() >= bend.abs() { 0.0 } else { -slope / bend };
            let hz = (bin as f64 + shift) * f64::from(SAMPLE_RATE_HZ) / FRAME as f64;
            (hz, frame[bin] + 0.5 * slope * shift)
        })
        .collect()
}
