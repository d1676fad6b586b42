//! The fitted curve of an effect of a wagon: the law that it changes, over the variable that it depends on, with its band.

use crate::answer::supplement::{Axis, Curve, CurvePoint};
use crate::data::case::Case;
use crate::fit::solver::{self, Block};
use crate::model::discrepancy::{Covariate, along};
use crate::model::parameters::{Built, Shape};
use nalgebra::{DMatrix, DVector};
use railgrip_vehicle::adhesion::friction;
use railgrip_vehicle::effects::{Effect, Observation, Operating};
use railgrip_vehicle::resistance::running_resistance;
use railgrip_vehicle::{GRAVITY_M_S2, MAX_WHEELSETS, RailClass};

/// Points of a curve.
const CURVE_POINTS: usize = 61;
/// Normal quantile of a two-sided 95 % interval.
const Z95: f64 = 1.96;
/// Step of a derivative, as a share of a parameter's scale.
const STEP: f64 = 1e-3;
/// Slip velocity up to which falling friction is shown, m/s.
const MOST_SLIP_M_S: f64 = 6.0;

/// A fitted model, and how well its parameters are known.
pub struct FittedModel<'a> {
    /// The shape.
    pub shape: &'a Shape,
    /// Its parameters.
    pub theta: &'a [f64],
    /// Normal equations of each run at the fit.
    pub blocks: &'a [Block],
    /// Factor by which standard errors are widened.
    pub widening: f64,
}

/// The fitted curve of the effect `id`, with its band; `None` for effects that are no function of one variable.
pub fn effect_curve(case: &Case, fitted: &FittedModel<'_>, calibrated: &Built, id: &str) -> Option<Curve> {
    let index = fitted.shape.effects.iter().position(|effect| effect.spec.id == id)?;
    let law = Law::of(id, case)?;
    let class = rail_of(case);
    let first = case.vehicle.effects.len();
    let curve_at = |theta: &[f64]| -> Vec<f64> {
        let built = fitted.shape.build(theta);
        let effect = built.model.effects().get(first + index).map(AsRef::as_ref);
        law.grid().map(|x| (law.value)(&Situation { built: &built, class, effect }, x)).collect()
    };
    let best = curve_at(fitted.theta);
    let errors = band(fitted, &curve_at).unwrap_or_else(|| vec![f64::NAN; best.len()]);
    let plain = Situation { built: calibrated, class, effect: None };
    let points = law.grid().zip(best.iter().zip(&errors)).map(|(x, (&y, error))| CurvePoint {
        x: law.shown(x),
        y,
        low: y - Z95 * error,
        high: y + Z95 * error,
    });
    Some(Curve {
        title: id.to_owned(),
        equation: fitted.shape.effects[index].spec.equation.to_owned(),
        x: Axis { label: law.x.0.to_owned(), unit: law.x.1.to_owned() },
        y: Axis { label: law.y.0.to_owned(), unit: law.y.1.to_owned() },
        points: points.collect(),
        reference: law.grid().map(|x| [law.shown(x), (law.value)(&plain, x)]).collect(),
        data: Vec::new(),
        region: None,
    })
}

/// Standard error of a curve at each of its points, by the delta method; `None` where the fit does not say.
fn band(fitted: &FittedModel<'_>, curve: &dyn Fn(&[f64]) -> Vec<f64>) -> Option<Vec<f64>> {
    let parameters = fitted.shape.parameters();
    let curvature = solver::assemble(parameters, fitted.theta, fitted.blocks).1;
    let n = parameters.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        curvature[(i, j)] * parameters[i].scale * parameters[j].scale + if i == j { 1e-9 } else { 0.0 }
    });
    let covariance = scaled.try_inverse()?;
    let columns: Vec<DVector<f64>> = (0..n)
        .map(|i| {
            let moved = |sign: f64| {
                let mut theta = fitted.theta.to_vec();
                theta[i] += sign * STEP * parameters[i].scale;
                DVector::from_vec(curve(&theta))
            };
            (moved(1.0) - moved(-1.0)) / (2.0 * STEP)
        })
        .collect();
    let jacobian = DMatrix::from_columns(&columns);
    let spread = &jacobian * covariance;
    let error = |k: usize| spread.row(k).dot(&jacobian.row(k)).max(0.0).sqrt() * fitted.widening;
    Some((0..jacobian.nrows()).map(error).collect())
}

/// Rail class whose adhesion a curve shows: the driest among the runs.
fn rail_of(case: &Case) -> RailClass {
    let present = |class: &RailClass| case.fit.iter().any(|run| run.rail == *class);
    RailClass::ALL.into_iter().find(present).unwrap_or(RailClass::Dry)
}

/// A model at which a law is asked.
struct Situation<'a> {
    built: &'a Built,
    class: RailClass,
    effect: Option<&'a dyn Effect>,
}

/// A law as a function of one variable.
struct Law {
    x: (&'static str, &'static str),
    y: (&'static str, &'static str),
    range: (f64, f64),
    scale: f64,
    value: fn(&Situation<'_>, f64) -> f64,
}

impl Law {
    fn of(id: &str, case: &Case) -> Option<Self> {
        let most = |covariate: Covariate| {
            let columns = case.fit.iter().flat_map(|run| along(case, run, covariate));
            columns.filter(|x| x.is_finite()).fold(0.0, f64::max)
        };
        let force = || {
            case.fit
                .iter()
                .flat_map(|run| &run.samples)
                .map(|s| s.input.pressing_force_n[0])
                .fold(1e3, f64::max)
        };
        let track = || case.fit.iter().flat_map(|run| &run.samples).map(|s| s.input.position_m);
        let friction_axis = ("pad friction, front", "");
        let law = |x, y, range, scale, value| Some(Self { x, y, range, scale, value });
        let (speed, pressing) = (("speed", "m/s"), ("pressing force", "kN"));
        match id {
            "brake_friction_speed" | "cast_iron" => {
                law(speed, friction_axis, (0.0, most(Covariate::Speed)), 1.0, over_speed)
            }
            "brake_friction_pressure" => law(pressing, friction_axis, (2e3, force()), 1e-3, over_force),
            "brake_fade" => {
                let top = most(Covariate::Temperature).max(20.0);
                law(
                    ("disc temperature above the surroundings", "K"),
                    friction_axis,
                    (0.0, top),
                    1.0,
                    over_hidden,
                )
            }
            "brake_wet_delay" => law(("energy braked", "MJ"), friction_axis, (0.0, 3e6), 1e-6, over_hidden),
            "pressing_force_offset" => {
                law(pressing, ("force on the pad", "N"), (0.0, force()), 1e-3, pad_force)
            }
            "falling_friction" => law(
                ("slip velocity", "m/s"),
                ("adhesion available", ""),
                (0.0, MOST_SLIP_M_S),
                1.0,
                over_slip,
            ),
            "adhesion_speed" => law(
                speed,
                ("adhesion available", ""),
                (0.5, most(Covariate::Speed)),
                1.0,
                adhesion_over_speed,
            ),
            "low_adhesion_patch" | "grade" => {
                let range =
                    (track().fold(f64::INFINITY, f64::min), track().fold(f64::NEG_INFINITY, f64::max));
                let place = ("position", "m");
                match id {
                    "grade" => law(place, ("error of the grade", "‰"), range, 1.0, grade_permil),
                    _ => law(place, ("adhesion available, front", ""), range, 1.0, adhesion_over_position),
                }
            }
            "running_resistance" | "headwind" => {
                law(speed, ("running resistance", "N"), (0.5, most(Covariate::Speed)), 1.0, resistance)
            }
            "wheel_encoder_eccentricity" => {
                let turn = (0.0, std::f64::consts::TAU);
                law(("wheel angle", "rad"), ("relative error of the reading", ""), turn, 1.0, over_angle)
            }
            _ => None,
        }
    }

    fn grid(&self) -> impl Iterator<Item = f64> {
        let (low, high) = self.range;
        (0..CURVE_POINTS).map(move |i| low + (high - low) * i as f64 / (CURVE_POINTS - 1) as f64)
    }

    fn shown(&self, x: f64) -> f64 {
        self.scale * x
    }
}

fn pad(at: &Situation<'_>, point: &Operating, hidden: &[f64]) -> f64 {
    let level = at.built.model.constants().brake_friction[0];
    at.effect.map_or(level, |effect| effect.brake_friction(0, point, hidden, level))
}

fn over_speed(at: &Situation<'_>, x: f64) -> f64 {
    // Of a wheelset that rolls: the disc turns with it.
    let wheel_speed_rad_s = at.built.model.constants().wheel_radius_m.map(|radius_m| x / radius_m);
    pad(at, &Operating { v_m_s: x, wheel_speed_rad_s, ..Operating::default() }, &[0.0; MAX_WHEELSETS])
}

fn over_force(at: &Situation<'_>, x: f64) -> f64 {
    pad(
        at,
        &Operating { pressing_force_n: [x; MAX_WHEELSETS], ..Operating::default() },
        &[0.0; MAX_WHEELSETS],
    )
}

fn over_hidden(at: &Situation<'_>, x: f64) -> f64 {
    pad(at, &Operating { adhesion_peak: [0.1; MAX_WHEELSETS], ..Operating::default() }, &[x; MAX_WHEELSETS])
}

fn pad_force(at: &Situation<'_>, x: f64) -> f64 {
    let point = Operating { pressing_force_n: [x; MAX_WHEELSETS], ..Operating::default() };
    at.effect.map_or(x, |effect| effect.pad_force_n(0, &point, &[], x))
}

fn over_slip(at: &Situation<'_>, x: f64) -> f64 {
    friction(&at.built.model.constants().contact, at.built.adhesion(at.class), x).0
}

fn peak(at: &Situation<'_>, point: &Operating) -> f64 {
    let level = at.built.adhesion(at.class);
    at.effect.map_or(level, |effect| effect.adhesion_peak(0, point, &[], level))
}

fn adhesion_over_speed(at: &Situation<'_>, x: f64) -> f64 {
    peak(at, &Operating { v_m_s: x, ..Operating::default() })
}

fn adhesion_over_position(at: &Situation<'_>, x: f64) -> f64 {
    peak(at, &Operating { position_m: x, ..Operating::default() })
}

fn grade_permil(at: &Situation<'_>, x: f64) -> f64 {
    let point = Operating { position_m: x, ..Operating::default() };
    let weight = at.built.model.constants().mass_kg * GRAVITY_M_S2;
    at.effect.map_or(0.0, |effect| -1e3 * effect.body_force_n(&point, &[], 0.0) / weight)
}

fn resistance(at: &Situation<'_>, x: f64) -> f64 {
    let point = Operating { v_m_s: x, ..Operating::default() };
    let wind = at.effect.map_or(0.0, |effect| effect.headwind_m_s(&point, &[], 0.0));
    let added = at.effect.map_or(0.0, |effect| effect.body_force_n(&point, &[], 0.0));
    running_resistance(&at.built.model.constants().resistance, x, wind) - added
}

fn over_angle(at: &Situation<'_>, x: f64) -> f64 {
    let point = Operating { wheel_angle_rad: [x; MAX_WHEELSETS], ..Operating::default() };
    let mut reading = Observation { v_m_s: 0.0, wheel_speed_rad_s: [1.0; MAX_WHEELSETS] };
    if let Some(effect) = at.effect {
        effect.observe(&point, &[], &mut reading);
    }
    let away = reading.wheel_speed_rad_s.map(|speed| speed - 1.0);
    away.into_iter().take(2).fold(0.0, |most: f64, x| if x.abs() > most.abs() { x } else { most })
}
