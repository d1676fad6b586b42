//! Draws some time of one train's day as an SVG: speed, retardation, pressing forces, couplers, loads, slip, friction.
//!
//! `cargo run --release -p railgrip-truth-plant --example plot_train -- SEED FAMILY FAULT FROM_S TO_S FILE.svg`
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use plotters::prelude::*;
use railgrip_truth_plant::train::{FaultWish, Journey, Reading, TrainOrder, TrainSpec, Truth};

/// A panel: its title and lines, each a name and points over time.
type Panel = (&'static str, Vec<(String, Vec<(f64, f64)>)>);

struct Sample {
    time_s: f64,
    ordered: f64,
    readings: Vec<Reading>,
    truths: Vec<Truth>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, seed, family, fault, from_s, to_s, file] = arguments.as_slice() else {
        println!("usage: plot_train SEED FAMILY FAULT FROM_S TO_S FILE.svg");
        return;
    };
    let (from_s, to_s): (f64, f64) = (from_s.parse().unwrap(), to_s.parse().unwrap());
    let fault = if fault == "none" { FaultWish::None } else { FaultWish::Of(fault) };
    let hours = (to_s / 3600.0).max(0.1);
    let order = TrainOrder { family: Some(family), hours, fault, ..TrainOrder::default() };
    let mut journey = Journey::new(TrainSpec::draw_to(seed.parse().unwrap(), &order).unwrap());
    let concerned = journey.spec().fault.map_or(journey.spec().wagons.len() / 2, |fault| fault.wagon);
    let mut samples = Vec::new();
    while journey.advance() {
        let time_s = journey.truths()[0].time_s;
        if time_s >= from_s {
            samples.push(Sample {
                time_s,
                ordered: journey.brake_ordered(),
                readings: journey.readings().to_vec(),
                truths: journey.truths().to_vec(),
            });
        }
    }
    println!("fault {:?}, onset {:?}", journey.spec().fault.map(|fault| fault.size), journey.onset_s());
    draw(file, &panels(&samples, concerned, journey.spec().wagons[concerned].wheelsets()));
}

fn panels(samples: &[Sample], concerned: usize, wheelsets: usize) -> Vec<Panel> {
    let line = |of: &dyn Fn(&Sample) -> f64| -> Vec<(f64, f64)> {
        samples.iter().map(|sample| (sample.time_s, of(sample))).filter(|point| point.1.is_finite()).collect()
    };
    let count = samples[0].truths.len();
    let places = [0, count / 2, count - 1];
    let places = &places[..if count > 2 { 3 } else { 1 }];
    let along = |of: &dyn Fn(&Truth) -> f64| {
        places
            .iter()
            .map(|place| (format!("wagon {}", place + 1), line(&|sample| of(&sample.truths[*place]))))
            .collect::<Vec<_>>()
    };
    let each = |of: &dyn Fn(&Sample, usize) -> f64| {
        (0..wheelsets)
            .map(|k| (format!("wagon {} wheelset {}", concerned + 1, k + 1), line(&|sample| of(sample, k))))
            .collect::<Vec<_>>()
    };
    vec![
        ("speed, m/s; order x 10", {
            let mut lines = along(&|truth| truth.v_m_s);
            lines.push(("brake order x 10".to_owned(), line(&|sample| 10.0 * sample.ordered)));
            lines
        }),
        ("acceleration, m/s²", along(&|truth| truth.acceleration_m_s2)),
        ("pad force of wheelset 1, kN", along(&|truth| truth.pad_force_n[0] / 1e3)),
        ("coupler behind, kN", along(&|truth| truth.coupler_n / 1e3)),
        ("wheel load, kN", each(&|sample, k| sample.truths[concerned].load_n[k] / 1e3)),
        (
            "creepage, %",
            each(&|sample, k| {
                let truth = &sample.truths[concerned];
                if truth.v_m_s > 2.0 { 100.0 * truth.slip_m_s[k] / truth.v_m_s } else { f64::NAN }
            }),
        ),
        ("utilised adhesion", each(&|sample, k| sample.truths[concerned].mu_w_wheelset[k])),
        ("rail and pad friction", {
            let mut lines = each(&|sample, k| sample.truths[concerned].pad_friction[k]);
            lines.extend(each(&|sample, k| sample.truths[concerned].rail[k]));
            lines
        }),
        (
            "measured pressing force, kN",
            each(&|sample, k| sample.readings[concerned].pressing_force_n[k] / 1e3),
        ),
        (
            "measured rim over file less measured speed, m/s",
            each(&|sample, k| {
                let reading = &sample.readings[concerned];
                let truth = &sample.truths[concerned];
                reading.wheel_speed_rad_s[k] * (truth.v_m_s + truth.slip_m_s[k])
                    / truth.wheel_speed_rad_s[k].max(0.1)
                    - reading.v_m_s
            }),
        ),
        ("pad temperature, °C", along(&|truth| truth.temperature_c[0])),
    ]
}

fn draw(file: &str, panels: &[Panel]) {
    let root = SVGBackend::new(file, (1500, 190 * panels.len() as u32)).into_drawing_area();
    root.fill(&WHITE).unwrap();
    for (area, (title, lines)) in root.split_evenly((panels.len(), 1)).iter().zip(panels) {
        let all = || lines.iter().flat_map(|(_, points)| points);
        let low = all().map(|point| point.1).fold(f64::INFINITY, f64::min);
        let high = all().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
        let first = all().map(|point| point.0).fold(f64::INFINITY, f64::min);
        let last = all().map(|point| point.0).fold(f64::NEG_INFINITY, f64::max);
        let margin = 0.05 * (high - low).max(1e-6);
        let mut chart = ChartBuilder::on(area)
            .margin(6)
            .x_label_area_size(18)
            .y_label_area_size(60)
            .caption(*title, ("sans-serif", 14))
            .build_cartesian_2d(first..last, low - margin..high + margin)
            .unwrap();
        chart.configure_mesh().light_line_style(TRANSPARENT).draw().unwrap();
        for (index, (name, points)) in lines.iter().enumerate() {
            let colour = Palette99::pick(index).to_rgba();
            let every = (points.len() / 3000).max(1);
            let thinned = points.iter().copied().step_by(every);
            chart
                .draw_series(LineSeries::new(thinned, colour))
                .unwrap()
                .label(name)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 12, y)], colour));
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.7))
            .label_font(("sans-serif", 10))
            .draw()
            .unwrap();
    }
    root.present().unwrap();
}
