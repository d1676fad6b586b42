//! A law-level case in memory: which law was measured, what the simulator believes, and the points.

use super::point::{Covariate, Point};

/// Which law a bench measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Creep force over creepage.
    Creep,
    /// Brake friction.
    Brake,
}

impl Kind {
    /// Name of the measured column.
    pub const fn signal(self) -> &'static str {
        match self {
            Self::Creep => "force_n",
            Self::Brake => "mu",
        }
    }

    /// The variables that such a bench may have.
    pub const fn variables(self) -> &'static [Covariate] {
        match self {
            Self::Creep => &[Covariate::Creepage, Covariate::SlipVelocity, Covariate::Speed, Covariate::Load],
            Self::Brake => &[Covariate::Speed, Covariate::Temperature, Covariate::PressingForce],
        }
    }

    /// Place in the equations that the bench isolates.
    pub const fn term(self) -> &'static str {
        match self {
            Self::Creep => "adhesion",
            Self::Brake => "brake_friction",
        }
    }
}

/// What the simulator believes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nominal {
    /// Polach's law with constant friction.
    Creep {
        /// Friction coefficient.
        mu0: f64,
        /// K = G π a b C11 / 4, N.
        stiffness_n: f64,
        /// Reduction of stiffness in the area of adhesion.
        k_a: f64,
        /// Reduction of stiffness in the area of slip.
        k_s: f64,
    },
    /// Constant pad friction.
    Brake {
        /// Friction coefficient.
        friction_coefficient: f64,
    },
}

/// A checked case.
#[derive(Clone, Debug)]
pub struct LawCase {
    /// Name of the folder.
    pub name: String,
    /// Which law is measured.
    pub kind: Kind,
    /// What the simulator believes.
    pub nominal: Nominal,
    /// Declared one-sigma accuracy of the measured column.
    pub sigma: Option<f64>,
    /// Points to fit on.
    pub fit: PointSet,
    /// Points that may only be predicted.
    pub holdout: PointSet,
}

/// The points of one folder.
#[derive(Clone, Debug, Default)]
pub struct PointSet {
    /// Names of the files without their endings.
    pub files: Vec<String>,
    /// Points in the order of files and rows.
    pub points: Vec<Point>,
}
