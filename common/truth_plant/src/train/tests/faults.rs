//! Each fault shows where it should, and not before it begins.

use super::super::{
    FaultWish, Journey, TrainOrder, TrainSpec,
    faults::{ActsOn, Begins, FAULTS, Fault, FaultKind, Shows},
    label::Witness,
};
use super::{Sample, drawn, mean, on_rail, run};

/// A train with the fault in a wagon without motors (with sanders where it needs them), large, and its healthy twin.
fn pair(kind: &'static FaultKind) -> (TrainSpec, TrainSpec) {
    let family = if kind.acts_on == ActsOn::Sander { "multiple_unit" } else { "coaches" };
    let order = |fault| TrainOrder {
        family: Some(family),
        wagons: Some(4),
        hours: 0.35,
        rate_hz: 50.0,
        fault,
        ..TrainOrder::default()
    };
    let fits = |spec: &TrainSpec| {
        spec.fault.is_some_and(|fault| {
            let motored = spec.wagons[fault.wagon].is_motored();
            let right_wagon = match kind.acts_on {
                ActsOn::Line => true,
                // Those behind find the sand of those ahead.
                ActsOn::Sander => fault.wagon == 0,
                _ => !motored,
            };
            fault.is_gross() && right_wagon
        })
    };
    let seed =
        (0..400).find(|seed| fits(&drawn(*seed, &order(FaultWish::Of(kind.id))))).expect("a gross one");
    let prepared = |fault| {
        let spec = drawn(seed, &order(fault));
        let low = spec.line.low.clone();
        let slippery = kind.shows == Shows::Sliding && kind.acts_on != ActsOn::Line;
        let mut spec = on_rail(spec, if slippery { 0.03 } else { 0.3 });
        if slippery {
            // No wheelset cleans the rail for the next.
            spec.weather.cleaning_j_per_m = 1e9;
        }
        if slippery && kind.acts_on != ActsOn::Sander {
            spec.wagons.iter_mut().for_each(|wagon| wagon.real.sander = false);
        }
        if kind.id == "brake_fade" {
            spec.wagons.iter_mut().for_each(|wagon| wagon.real.gear.pads.heat_j_per_k = 3e4);
        }
        if kind.acts_on == ActsOn::Line && spec.fault.is_some() {
            spec.line.low = low;
        }
        spec
    };
    (prepared(FaultWish::Of(kind.id)), prepared(FaultWish::None))
}

/// What is looked at in one sample: wagon and wheelset concerned, and the spec.
struct Look<'a> {
    spec: &'a TrainSpec,
    fault: &'a Fault,
    samples: &'a [Sample],
}

impl Look<'_> {
    /// Mean over samples that pass of a value; samples without the value are left out.
    fn mean(&self, pass: impl Fn(&Sample) -> bool, value: impl Fn(&Sample) -> f64) -> f64 {
        mean(self.samples.iter().filter(|sample| pass(sample)).map(value).filter(|value| value.is_finite()))
            .unwrap_or(f64::NAN)
    }

    fn spread(&self, pass: impl Fn(&Sample) -> bool, value: impl Fn(&Sample) -> f64) -> f64 {
        self.mean(pass, |sample| value(sample).powi(2)).sqrt()
    }

    fn full_n(&self) -> f64 {
        self.spec.wagons[self.fault.wagon].real.gear.full_force_n[self.fault.wheelset]
    }

    /// Mean time from an order to so much of full pressing, s; `limit_s` where it never comes.
    fn response_s(&self, share: f64, limit_s: f64) -> f64 {
        let starts = self.samples.windows(2).enumerate();
        let starts = starts
            .filter(|(_, pair)| pair[0].order == 0.0 && pair[1].order > 0.0 && pair[1].truths[0].v_m_s > 8.0);
        let time = |from: usize| {
            let began_s = self.samples[from].time_s;
            let pressed =
                |sample: &&Sample| sample.truths[self.fault.wagon].pad_force_n[0] > share * self.full_n();
            let after = self.samples[from..].iter().find(pressed);
            after.map_or(limit_s, |sample| (sample.time_s - began_s).min(limit_s))
        };
        mean(starts.map(|(from, _)| time(from))).unwrap_or(f64::NAN)
    }

    /// The figure in which this fault shows.
    fn figure(&self) -> f64 {
        let (w, k) = (self.fault.wagon, self.fault.wheelset);
        let file = &self.spec.wagons[w].file;
        let braking = |sample: &Sample| sample.order > 0.25 && sample.truths[w].v_m_s > 5.0;
        let released = |sample: &Sample| sample.order == 0.0 && sample.truths[w].v_m_s > 15.0;
        let rolling = |sample: &Sample| sample.truths[w].v_m_s > 10.0;
        let pressed = |sample: &Sample| sample.readings[w].pressing_force_n[k] / self.full_n();
        let turn_error = |sample: &Sample| {
            let truth = &sample.truths[w];
            sample.readings[w].wheel_speed_rad_s[k] / truth.wheel_speed_rad_s[k] - 1.0
        };
        match self.fault.kind.id {
            "dragging_pad" => self.mean(released, |sample| sample.truths[w].braked_nm[k]),
            "hand_brake" => self.mean(released, |sample| sample.truths[w].braked_nm[0]),
            "dragging_distributor" => self.mean(released, pressed),
            "isolated_wheelset" | "isolated_wagon" | "isolated_rear_part" | "slide_valve_vents" => {
                self.mean(braking, pressed)
            }
            "glazed_pad" | "worn_pads" => self.mean(braking, |sample| sample.truths[w].pad_friction[k]),
            "brake_fade" => self.mean(
                |sample| braking(sample) && sample.truths[w].temperature_c[k] > 90.0,
                |sample| sample.truths[w].pad_friction[k],
            ),
            "slow_cylinder" => self.response_s(0.25, 15.0),
            "late_distributor" => self.response_s(0.03, 15.0),
            "leaking_cylinder" => self.mean(braking, |sample| {
                let other = (k + 1) % 4;
                sample.readings[w].pressing_force_n[k] / sample.readings[w].pressing_force_n[other]
            }),
            "slide_valve_dead" => self.mean(braking, |sample| sample.truths[w].slip_m_s[k]),
            "wheel_flat" => {
                self.spread(rolling, |sample| turn_error(sample) * sample.truths[w].wheel_speed_rad_s[k])
            }
            "tachometer_eccentric" => self.spread(rolling, turn_error),
            "tachometer_late" => self.spread(braking, turn_error),
            "tachometer_dropout" | "silent_wheelset" => self.mean(rolling, |sample| {
                f64::from(u8::from(sample.readings[w].wheel_speed_rad_s[k].is_nan()))
            }),
            "wheel_diameter" => self.mean(released, |sample| {
                sample.readings[w].wheel_speed_rad_s[k] * file.radius_m / sample.truths[w].v_m_s
            }),
            "speed_late" => self.mean(braking, |sample| sample.readings[w].v_m_s - sample.truths[w].v_m_s),
            "speed_scale" => {
                self.mean(rolling, |sample| sample.readings[w].v_m_s / sample.truths[w].v_m_s - 1.0)
            }
            "pressure_offset" => {
                self.mean(braking, |sample| pressed(sample) - sample.truths[w].pad_force_n[k] / self.full_n())
            }
            "sander_empty" => {
                self.mean(|sample| sample.readings[w].sanding > 0.5, |sample| sample.truths[w].rail[k])
            }
            "low_stretch" => -self.mean(
                |sample| sample.order > 0.1,
                |sample| f64::from(u8::from(sample.truths[0].rail[0] < 0.13)),
            ),
            "payload_entry" => (self.spec.wagons[w].real.mass_kg / file.mass_kg - 1.0) / file.mass_sigma,
            "silent_wagon" => {
                self.mean(|_| true, |sample| f64::from(u8::from(sample.readings[w].v_m_s.is_nan())))
            }
            other => panic!("no figure for {other}"),
        }
    }
}

/// By how much the figure must change at least: a factor, or where the healthy figure is near zero an amount.
fn least_change(kind: &FaultKind, size: f64, healthy: f64) -> f64 {
    match kind.id {
        "dragging_pad" | "hand_brake" => 100.0,
        "dragging_distributor" => 0.7 * size,
        "isolated_wheelset" | "isolated_wagon" | "isolated_rear_part" => 0.8 * healthy,
        "slide_valve_vents" => 0.7 * size * healthy,
        "glazed_pad" | "worn_pads" => 0.8 * size * healthy,
        "brake_fade" => 0.05 * healthy,
        "slow_cylinder" => 0.5,
        "late_distributor" => 0.7 * size,
        "leaking_cylinder" => 0.06,
        "slide_valve_dead" => 0.5,
        "wheel_flat" => 0.02,
        // A sine of which the reading's own lag leaves six tenths at speed.
        "tachometer_eccentric" => 0.3 * size,
        "tachometer_late" => 0.003,
        "tachometer_dropout" | "silent_wheelset" => 0.7 * size,
        "wheel_diameter" | "speed_scale" => 0.8 * size.abs(),
        // In sigmas of what the file says of its own mass.
        "payload_entry" => 5.0,
        "speed_late" => 0.3 * size,
        "pressure_offset" => 0.5 * size.abs(),
        "sander_empty" => 0.02,
        "low_stretch" => 0.02,
        "silent_wagon" => 0.99,
        other => panic!("no change for {other}"),
    }
}

#[test]
fn each_fault_shows_where_it_should_and_not_before_it_begins() {
    for kind in &FAULTS {
        let (faulty, healthy) = pair(kind);
        let fault = faulty.fault.expect("placed");
        let (with, without) = (run(faulty.clone()), run(healthy.clone()));
        let onset =
            with.iter().position(|sample| sample.onset).unwrap_or_else(|| panic!("{} never begins", kind.id));
        if kind.begins == Begins::OnTheWay {
            assert!(onset > 0);
            let same = with[..onset].iter().zip(&without).all(|(one, other)| {
                let bytes = |sample: &Sample| format!("{:?}", sample.readings);
                bytes(one) == bytes(other)
            });
            assert!(same, "{} shows before it begins", kind.id);
        }
        let look = |spec, samples| Look { spec, fault: &fault, samples }.figure();
        let (sick, well) = (look(&faulty, &with[onset..]), look(&healthy, &without[onset..]));
        let least = least_change(kind, fault.size, well.abs());
        println!(
            "{:22} size {:8.3}: {sick:9.4} against {well:9.4}, at least {least:.4} apart",
            kind.id, fault.size
        );
        assert!((sick - well).abs() >= least, "{}: {sick} against {well}", kind.id);
    }
}

/// Pads that stay cool do not fade, and on a stretch that is no lower than the rest nothing slides: the fault is there and cannot be seen.
#[test]
fn a_label_says_whether_a_fade_or_a_low_stretch_could_be_seen() {
    let label = |spec: TrainSpec| {
        let mut journey = Journey::new(spec);
        let mut witness = Witness::default();
        while journey.advance() {
            witness.observe(&journey);
        }
        witness.label("train", &journey).fault.expect("it began")
    };
    let seen = |id: &str, prepare: &dyn Fn(&mut TrainSpec)| {
        let (mut spec, _) = pair(FaultKind::of(id).expect("a kind"));
        prepare(&mut spec);
        let fault = label(spec);
        assert!(fault.brakings_after_onset > 2, "{id}: {fault:?}");
        fault.brakings_showing
    };
    let heat = |j_per_k: f64| {
        move |spec: &mut TrainSpec| {
            spec.wagons.iter_mut().for_each(|wagon| wagon.real.gear.pads.heat_j_per_k = j_per_k)
        }
    };
    let (hot, cool) = (seen("brake_fade", &heat(2e4)), seen("brake_fade", &heat(1e7)));
    assert!(hot > 0 && cool == 0, "{hot} {cool}");
    let low = |friction: f64| {
        move |spec: &mut TrainSpec| spec.line.low.iter_mut().for_each(|low| low.friction = friction)
    };
    let (slides, grips) = (seen("low_stretch", &low(0.02)), seen("low_stretch", &low(0.3)));
    assert!(slides > 0 && grips == 0, "{slides} {grips}");
}
