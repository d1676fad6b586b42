//! A departure put together from a hidden state and laws at the places that it touches.

use super::{
    moment::{Departure, Moment, Sensed},
    wagon::FamilyWagon,
};

type Place<S> = Option<Box<dyn Fn(&S, &Moment) -> f64 + Send>>;
type PlaceOfWheelset<S> = Option<Box<dyn Fn(&S, usize, &Moment) -> f64 + Send>>;
type Force<S> = Option<Box<dyn Fn(&S, usize, f64, &Moment) -> f64 + Send>>;
type Advance<S> = Option<Box<dyn Fn(&mut S, &Moment) + Send>>;
type Sense<S> = Option<Box<dyn Fn(&mut S, &Moment, &mut Sensed) + Send>>;
type Adapt = Option<Box<dyn Fn(&mut FamilyWagon) + Send>>;

/// Hidden state and laws; what is not given leaves the wagon alone.
pub struct Law<S> {
    start: S,
    state: S,
    adapt: Adapt,
    advance: Advance<S>,
    pad_friction: PlaceOfWheelset<S>,
    pad_force: Force<S>,
    drag_torque: PlaceOfWheelset<S>,
    drive: PlaceOfWheelset<S>,
    shaft_torque: Force<S>,
    inertia: PlaceOfWheelset<S>,
    radius: PlaceOfWheelset<S>,
    rail_friction: PlaceOfWheelset<S>,
    load_transfer: Place<S>,
    extra_mass: Place<S>,
    body_force: Place<S>,
    headwind: Place<S>,
    grade_error: Place<S>,
    sense: Sense<S>,
}

/// A law without hidden state.
pub fn law() -> Law<()> {
    with_state(())
}

/// A law whose hidden state begins every run like this.
pub fn with_state<S: Clone>(start: S) -> Law<S> {
    Law {
        state: start.clone(),
        start,
        adapt: None,
        advance: None,
        pad_friction: None,
        pad_force: None,
        drag_torque: None,
        drive: None,
        shaft_torque: None,
        inertia: None,
        radius: None,
        rail_friction: None,
        load_transfer: None,
        extra_mass: None,
        body_force: None,
        headwind: None,
        grade_error: None,
        sense: None,
    }
}

/// Setters, one a place.
macro_rules! places {
    ($($(#[$doc:meta])* $name:ident: ($($argument:ty),*) $(-> $value:ty)?;)*) => {
        impl<S> Law<S> {
            $($(#[$doc])*
            pub fn $name(mut self, law: impl Fn($($argument),*) $(-> $value)? + Send + 'static) -> Self {
                self.$name = Some(Box::new(law));
                self
            })*
        }
    };
}

places! {
    /// See [`Departure::adapt`].
    adapt: (&mut FamilyWagon);
    /// See [`Departure::advance`].
    advance: (&mut S, &Moment);
    /// See [`Departure::pad_friction`].
    pad_friction: (&S, usize, &Moment) -> f64;
    /// See [`Departure::pad_force_n`].
    pad_force: (&S, usize, f64, &Moment) -> f64;
    /// See [`Departure::drag_torque_nm`].
    drag_torque: (&S, usize, &Moment) -> f64;
    /// See [`Departure::drive`].
    drive: (&S, usize, &Moment) -> f64;
    /// See [`Departure::shaft_torque_nm`].
    shaft_torque: (&S, usize, f64, &Moment) -> f64;
    /// See [`Departure::inertia`].
    inertia: (&S, usize, &Moment) -> f64;
    /// See [`Departure::radius`].
    radius: (&S, usize, &Moment) -> f64;
    /// See [`Departure::rail_friction`].
    rail_friction: (&S, usize, &Moment) -> f64;
    /// See [`Departure::load_transfer`].
    load_transfer: (&S, &Moment) -> f64;
    /// See [`Departure::extra_mass_kg`].
    extra_mass: (&S, &Moment) -> f64;
    /// See [`Departure::body_force_n`].
    body_force: (&S, &Moment) -> f64;
    /// See [`Departure::headwind_m_s`].
    headwind: (&S, &Moment) -> f64;
    /// See [`Departure::grade_error_rad`].
    grade_error: (&S, &Moment) -> f64;
    /// See [`Departure::sense`].
    sense: (&mut S, &Moment, &mut Sensed);
}

impl<S: Clone + Send + 'static> Law<S> {
    /// The finished departure.
    pub fn boxed(self) -> Box<dyn Departure> {
        Box::new(self)
    }
}

impl<S> Law<S> {
    fn of(&self, place: &Place<S>, now: &Moment, neutral: f64) -> f64 {
        place.as_ref().map_or(neutral, |law| law(&self.state, now))
    }

    fn at(&self, place: &PlaceOfWheelset<S>, wheelset: usize, now: &Moment, neutral: f64) -> f64 {
        place.as_ref().map_or(neutral, |law| law(&self.state, wheelset, now))
    }
}

impl<S: Clone + Send> Departure for Law<S> {
    fn begin(&mut self) {
        self.state = self.start.clone();
    }

    fn adapt(&self, wagon: &mut FamilyWagon) {
        if let Some(adapt) = &self.adapt {
            adapt(wagon);
        }
    }

    fn advance(&mut self, now: &Moment) {
        if let Some(advance) = &self.advance {
            advance(&mut self.state, now);
        }
    }

    fn pad_friction(&self, wheelset: usize, now: &Moment) -> f64 {
        self.at(&self.pad_friction, wheelset, now, 1.0)
    }

    fn pad_force_n(&self, wheelset: usize, force_n: f64, now: &Moment) -> f64 {
        self.pad_force.as_ref().map_or(force_n, |law| law(&self.state, wheelset, force_n, now))
    }

    fn drag_torque_nm(&self, wheelset: usize, now: &Moment) -> f64 {
        self.at(&self.drag_torque, wheelset, now, 0.0)
    }

    fn drive(&self, wheelset: usize, now: &Moment) -> f64 {
        self.at(&self.drive, wheelset, now, 1.0)
    }

    fn shaft_torque_nm(&self, wheelset: usize, torque_nm: f64, now: &Moment) -> Option<f64> {
        self.shaft_torque.as_ref().map(|law| law(&self.state, wheelset, torque_nm, now))
    }

    fn inertia(&self, wheelset: usize, now: &Moment) -> f64 {
        self.at(&self.inertia, wheelset, now, 1.0)
    }

    fn radius(&self, wheelset: usize, now: &Moment) -> f64 {
        self.at(&self.radius, wheelset, now, 1.0)
    }

    fn rail_friction(&self, wheelset: usize, now: &Moment) -> f64 {
        self.at(&self.rail_friction, wheelset, now, 1.0)
    }

    fn load_transfer(&self, now: &Moment) -> f64 {
        self.of(&self.load_transfer, now, 1.0)
    }

    fn extra_mass_kg(&self, now: &Moment) -> f64 {
        self.of(&self.extra_mass, now, 0.0)
    }

    fn body_force_n(&self, now: &Moment) -> f64 {
        self.of(&self.body_force, now, 0.0)
    }

    fn headwind_m_s(&self, now: &Moment) -> f64 {
        self.of(&self.headwind, now, 0.0)
    }

    fn grade_error_rad(&self, now: &Moment) -> f64 {
        self.of(&self.grade_error, now, 0.0)
    }

    fn sense(&mut self, now: &Moment, shown: &mut Sensed) {
        if let Some(sense) = &self.sense {
            sense(&mut self.state, now, shown);
        }
    }
}
