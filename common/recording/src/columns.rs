//! The columns of a run: their names, units and what values a sensor can give.
//!
//! A wagon with two wheelsets has the suffixes `f` (front) and `r` (rear); with any other number of wheelsets they are
//! numbered from the front: `omega_1_rad_s`, `omega_2_rad_s`, ... A reader takes numbers for two wheelsets as well.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

/// Most wheelsets a wagon can have.
pub const MAX_WHEELSETS: usize = 4;

/// Time column of every run.
pub(crate) const TIME: &str = "t_s";

/// What a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time of the sample.
    Time,
    /// Vehicle speed, forward positive.
    Speed,
    /// Angular speed of a wheelset, positive rolling forward.
    WheelSpeed,
    /// Force between pad and disc, inferred from the brake cylinder's pressure.
    PressingForce,
    /// Torque on the wheelset beside brake and contact, positive driving forward.
    DriveTorque,
    /// Slope of the track, positive uphill.
    Grade,
    /// 1 while sand is laid, else 0.
    Sanding,
    /// Position along the track by satellite.
    Position,
    /// 1 while wheel-slide protection controls the wheelset, else 0.
    WspActive,
    /// Mass that the wagon's load sensors report, all of the wagon.
    Load,
    /// Brake that is ordered: 0 none, 1 a full brake.
    BrakeDemand,
}

impl Quantity {
    /// All quantities in the order of a file's columns.
    pub const ALL: [Self; 11] = [
        Self::Time,
        Self::Speed,
        Self::WheelSpeed,
        Self::PressingForce,
        Self::DriveTorque,
        Self::Grade,
        Self::Sanding,
        Self::Position,
        Self::WspActive,
        Self::Load,
        Self::BrakeDemand,
    ];

    /// Whether there is one column a wheelset.
    pub const fn per_wheelset(self) -> bool {
        matches!(self, Self::WheelSpeed | Self::PressingForce | Self::DriveTorque | Self::WspActive)
    }

    /// Whether a run without it is no run.
    pub const fn required(self) -> bool {
        matches!(self, Self::Time | Self::Speed | Self::WheelSpeed | Self::PressingForce)
    }

    /// Values a sensor can give, with room for noise. Beyond it the unit or the sign is wrong.
    pub const fn allowed(self) -> RangeInclusive<f64> {
        match self {
            Self::Time => -1e12..=1e12,
            Self::Speed => -200.0..=200.0,
            Self::WheelSpeed => -1e3..=1e3,
            Self::PressingForce => -2e3..=1e6,
            Self::DriveTorque => -1e6..=1e6,
            Self::Grade => -0.2..=0.2,
            Self::Sanding | Self::WspActive | Self::BrakeDemand => 0.0..=1.0,
            Self::Load => 0.0..=1e6,
            Self::Position => -1e8..=1e8,
        }
    }

    /// Unit of the column.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Speed => "m/s",
            Self::WheelSpeed => "rad/s",
            Self::PressingForce => "N",
            Self::DriveTorque => "N m",
            Self::Grade => "rad",
            Self::Sanding | Self::WspActive | Self::BrakeDemand => "(off to on)",
            Self::Load => "kg",
            Self::Position => "m",
        }
    }

    /// Name of the column, `wheelset` counted from 0 at the front.
    pub fn column(self, wheelset: usize, wheelsets: usize) -> String {
        let suffix = suffix(wheelset, wheelsets);
        match self {
            Self::Time => TIME.to_owned(),
            Self::Speed => "v_m_s".to_owned(),
            Self::WheelSpeed => format!("omega_{suffix}_rad_s"),
            Self::PressingForce => format!("f_perp_{suffix}_n"),
            Self::DriveTorque => format!("m_w_{suffix}_nm"),
            Self::Grade => "grade_rad".to_owned(),
            Self::Sanding => "sanding".to_owned(),
            Self::Position => "position_m".to_owned(),
            Self::WspActive => format!("wsp_{suffix}"),
            Self::Load => "load_kg".to_owned(),
            Self::BrakeDemand => "brake_demand".to_owned(),
        }
    }
}

/// `f`, `r` for two wheelsets, else `1`, `2`, ... from the front.
pub fn suffix(wheelset: usize, wheelsets: usize) -> String {
    match (wheelset, wheelsets) {
        (0, 2) => "f".to_owned(),
        (1, 2) => "r".to_owned(),
        _ => (wheelset + 1).to_string(),
    }
}

/// All columns of a run with so many wheelsets, in the order of a file.
pub(crate) fn columns_of_run(wheelsets: usize) -> Vec<(Quantity, usize, String)> {
    let mut columns = Vec::new();
    for quantity in Quantity::ALL {
        let count = if quantity.per_wheelset() { wheelsets } else { 1 };
        for wheelset in 0..count {
            columns.push((quantity, wheelset, quantity.column(wheelset, wheelsets)));
        }
    }
    columns
}

/// The usual name of a column: of two wheelsets that are numbered, `omega_1_rad_s` is `omega_f_rad_s`.
pub(crate) fn usual_name(name: &str, wheelsets: usize) -> String {
    let numbered = |quantity: &Quantity, wheelset: usize| quantity.column(wheelset, MAX_WHEELSETS) == name;
    let of_wheelset = |quantity: &Quantity| {
        let wheelset = (0..2).find(|wheelset| numbered(quantity, *wheelset))?;
        quantity.per_wheelset().then(|| quantity.column(wheelset, 2))
    };
    let found = if wheelsets == 2 { Quantity::ALL.iter().find_map(of_wheelset) } else { None };
    found.unwrap_or_else(|| name.to_owned())
}

/// How many wheelsets a header describes: the highest number of `omega_N_rad_s`, else two.
pub(crate) fn wheelsets_of_header(names: &[String]) -> usize {
    let numbered = |wheelset: &usize| names.contains(&format!("omega_{}_rad_s", wheelset + 1));
    (0..MAX_WHEELSETS).rev().find(numbered).map_or(2, |highest| highest + 1)
}

/// The columns as people read them in a message.
pub(crate) fn described(columns: &[(Quantity, usize, String)]) -> String {
    let mut text = String::new();
    for (position, (quantity, _, name)) in columns.iter().enumerate() {
        let separator = if position == 0 { "" } else { ", " };
        let optional = if quantity.required() { "" } else { " (optional)" };
        write!(text, "{separator}{name}{optional}").ok();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_two_wheelsets_are_those_of_the_contract() {
        let names: Vec<String> = columns_of_run(2).into_iter().map(|(_, _, name)| name).collect();
        assert_eq!(
            names.join(","),
            "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n,m_w_f_nm,m_w_r_nm,grade_rad,sanding,\
             position_m,wsp_f,wsp_r,load_kg,brake_demand"
        );
    }

    #[test]
    fn four_wheelsets_are_numbered_and_recognised() {
        let names: Vec<String> = columns_of_run(4).into_iter().map(|(_, _, name)| name).collect();
        assert!(names.contains(&"f_perp_4_n".to_owned()));
        assert_eq!(wheelsets_of_header(&names), 4);
        assert_eq!(wheelsets_of_header(&["t_s".to_owned()]), 2);
    }

    #[test]
    fn two_numbered_wheelsets_have_usual_names() {
        assert_eq!(usual_name("m_w_2_nm", 2), "m_w_r_nm");
        assert_eq!(usual_name("omega_1_rad_s", 2), "omega_f_rad_s");
        assert_eq!(usual_name("omega_1_rad_s", 1), "omega_1_rad_s");
        assert_eq!(usual_name("f_perp_3_n", 2), "f_perp_3_n");
        assert_eq!(usual_name("load_kg", 2), "load_kg");
    }
}
