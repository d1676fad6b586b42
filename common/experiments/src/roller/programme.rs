//! What is asked for and what lies on the rollers in each of the two tests.

use railgrip_vehicle::Contact;

/// Period of samples and of the slide protection, s.
pub const SAMPLE_PERIOD_S: f64 = 5e-3;

/// One of the two tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Test {
    /// Fig. 4: from 120 km/h, three short applications, then the stop under near-continuous slide protection.
    SlideProtection,
    /// Figs. 5 and 6: from 200 km/h with sand.
    Sanding,
}

/// Time course of what the operator asks for and what lies on the rollers.
pub(super) struct Programme {
    /// Speed at the start, m/s.
    pub start_speed_m_s: f64,
    /// Longest time, s.
    pub duration_s: f64,
    /// Demand as a share of full braking over time, held until the next entry.
    pub demand: &'static [(f64, f64)],
    /// Slip beyond which the protection vents.
    pub vent_slip: f64,
    /// Slip beyond which it holds.
    pub hold_slip: f64,
    /// Apply pulse and pause, s.
    pub pulse_s: (f64, f64),
    /// Contact law.
    pub contact: Contact,
}

impl Test {
    pub(super) fn programme(self) -> Programme {
        let contact = |friction_ratio, friction_decay_s_per_m| Contact {
            stiffness_n: 6e6,
            k_a: 1.0,
            k_s: 0.4,
            friction_ratio,
            friction_decay_s_per_m,
        };
        match self {
            Self::SlideProtection => Programme {
                start_speed_m_s: 120.0 / 3.6,
                duration_s: 135.0,
                demand: &[
                    (18.0, 0.30),
                    (20.5, 0.0),
                    (24.0, 0.30),
                    (26.5, 0.0),
                    (30.5, 0.30),
                    (33.0, 0.0),
                    (42.0, 1.0),
                ],
                vent_slip: 0.22,
                hold_slip: 0.10,
                pulse_s: (0.08, 0.18),
                contact: contact(0.4, 0.2),
            },
            Self::Sanding => Programme {
                start_speed_m_s: 200.0 / 3.6,
                duration_s: 140.0,
                demand: &[
                    (3.5, 1.4),
                    (6.3, 0.0),
                    (12.0, 0.60),
                    (19.0, 0.75),
                    (24.0, 0.45),
                    (30.0, 1.25),
                    (37.0, 0.80),
                    (52.0, 1.0),
                ],
                vent_slip: 0.45,
                hold_slip: 0.30,
                pulse_s: (0.3, 0.3),
                contact: contact(0.35, 0.15),
            },
        }
    }

    /// Adhesion available at a time, before slow random variation.
    pub(super) fn adhesion_peak(self, time_s: f64) -> f64 {
        let towards = |from: f64, to: f64, start_s: f64, length_s: f64| {
            from + (to - from) * ((time_s - start_s) / length_s).clamp(0.0, 1.0)
        };
        match self {
            // Water and soap, running dry towards the end.
            Self::SlideProtection => towards(0.050, 0.12, 108.0, 6.0),
            Self::Sanding => 0.106,
        }
    }
}

impl Programme {
    /// Demand at a time, as a share of full braking.
    pub fn demand_at(&self, time_s: f64) -> f64 {
        self.demand.iter().rev().find(|(from, _)| time_s >= *from).map_or(0.0, |(_, share)| *share)
    }
}
