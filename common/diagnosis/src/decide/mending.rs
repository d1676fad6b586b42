//! Mending: how a further effect relates to those named before it. The one definition, by which candidates are ordered,
//! accepted, and believed.
//!
//! A law of another form than the vehicle's leaves a rest, and a neighbour at the same place of the equations can take that
//! rest up without being there. So a further effect at a place where one before it shows must gain a good share of what
//! those there gained; with less it only mends their form.

use crate::decide::criteria::Acceptance;
use crate::model::places;
use railgrip_vehicle::effects::Term;

/// How a further effect relates to those named before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// It shows at none of their places.
    Apart,
    /// It shows at one of their places and gains enough to be an effect of its own.
    Beside,
    /// It shows at one of their places and gains so little that it only mends their form.
    Mends,
}

/// The relation of an effect of `term`, which gained `gain`, to those `before` it with what they gained.
pub fn relation(term: Term, gain: f64, before: &[(Term, f64)], acceptance: &Acceptance) -> Relation {
    let there = before.iter().filter(|(other, _)| places::may_share(*other, term));
    match there.map(|(_, gained)| *gained).reduce(|sum, gained| sum + gained) {
        None => Relation::Apart,
        Some(gained) if gain < acceptance.mending_share * gained => Relation::Mends,
        Some(_) => Relation::Beside,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_mends_only_where_one_before_it_shows_and_only_if_it_gains_little() {
        let acceptance = Acceptance::default();
        let before = [(Term::BrakeFriction, 1000.0), (Term::Resistance, 500.0)];
        let of = |term, gain| relation(term, gain, &before, &acceptance);
        assert_eq!(of(Term::SensorSpeed, 40.0), Relation::Apart);
        assert_eq!(of(Term::BrakeActuation, 40.0), Relation::Mends);
        assert_eq!(of(Term::BrakeActuation, 300.0), Relation::Beside);
        // What effects elsewhere gained does not count: a fifth of 500 is enough.
        assert_eq!(of(Term::LongitudinalForce, 120.0), Relation::Beside);
        assert_eq!(relation(Term::Adhesion, 1.0, &[], &acceptance), Relation::Apart);
    }
}
