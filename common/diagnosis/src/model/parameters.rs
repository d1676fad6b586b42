//! What is fitted: nuisances, which differ from case to case and are never the answer, and parameters of effects.

use crate::data::case::Case;
use crate::model::track_offset;
use railgrip_vehicle::effects::{Constructor, Effect, EffectSpec};
use railgrip_vehicle::{Constants, MAX_WHEELSETS, PerWheelset, RailClass, VehicleParameters, WagonModel};
use std::sync::Arc;

/// One fitted number.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name for people.
    pub name: String,
    /// Start of a fit.
    pub start: f64,
    /// Smallest allowed value.
    pub lower: f64,
    /// Largest allowed value.
    pub upper: f64,
    /// Size of a change that matters; sets finite-difference steps and damping.
    pub scale: f64,
    /// Centre of the prior.
    pub prior_mean: f64,
    /// One-sigma width of the prior, infinite where nothing is known.
    pub prior_sigma: f64,
    /// The run to fit on that alone it concerns; `None` for what concerns all.
    pub run: Option<usize>,
    /// The runs to fit on in which alone it can show, where that is known; others are not asked for its derivatives.
    pub shows_in: Option<Vec<usize>>,
}

/// A quantity of the nominal model that a case may have otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nuisance {
    /// Pad friction level of a wheelset.
    Pad(usize),
    /// Adhesion available on a class of rail.
    Adhesion(RailClass),
    /// Constant part of running resistance.
    ResistanceConstant,
    /// Drag.
    Drag,
    /// Mass.
    Mass,
    /// Moment of inertia of all wheelsets.
    Inertia,
    /// Contact stiffness: the slope with which adhesion rises with creepage.
    Stiffness,
    /// Share of the slip part of the contact patch (k_S), which shapes the tail of the creep curve.
    CreepTail,
}

impl Nuisance {
    /// Its range relative to the nominal value, down and up, and one sigma of its prior.
    fn range(self, vehicle: &VehicleParameters) -> ([f64; 2], f64) {
        // The contract's ranges, with a little room beyond them.
        let within = |half: f64| ([-1.1 * half, 1.1 * half], 0.6 * half);
        match self {
            // From leaves to the best dry rail: a prior that hardly says more than that.
            Self::Adhesion(RailClass::Undeclared) => ([-0.9, 0.6], 0.6),
            Self::Pad(_) | Self::Adhesion(_) => within(0.15),
            Self::ResistanceConstant | Self::Drag => within(0.10),
            Self::Mass => match vehicle.body.mass_sigma.filter(|sigma| *sigma > MASS_HALF_RANGE) {
                Some(sigma) => ([(-2.5 * sigma).max(-0.8), 2.5 * sigma], sigma),
                None => within(MASS_HALF_RANGE),
            },
            Self::Inertia => within(0.03),
            Self::Stiffness => within(0.05),
            Self::CreepTail => {
                // No more than one, from where on the law has no such share.
                let ([lower, upper], sigma) = within(0.05);
                ([lower, upper.min(1.0 / vehicle.contact.k_s - 1.0).max(0.0)], sigma)
            }
        }
    }

    fn name(self, wheelsets: usize) -> String {
        match self {
            Self::Pad(i) => match (wheelsets, i) {
                (2, 0) => "pad_friction_f".into(),
                (2, _) => "pad_friction_r".into(),
                _ => format!("pad_friction_{}", i + 1),
            },
            Self::Adhesion(class) => format!("adhesion_{}", class.name()),
            Self::ResistanceConstant => "resistance_constant".into(),
            Self::Drag => "drag".into(),
            Self::Mass => "mass".into(),
            Self::Inertia => "inertia".into(),
            Self::Stiffness => "contact_stiffness".into(),
            Self::CreepTail => "creep_tail".into(),
        }
    }

    fn parameter(self, vehicle: &VehicleParameters) -> Parameter {
        let ([lower, upper], prior_sigma) = self.range(vehicle);
        Parameter {
            name: self.name(vehicle.wheelsets()),
            start: 0.0,
            lower,
            upper,
            // A sixth of the prior's sigma, but no more than the model is straight over.
            scale: (prior_sigma / 6.0).min(0.02),
            prior_mean: 0.0,
            prior_sigma,
            run: None,
            shows_in: None,
        }
    }
}

/// The offset of position of one of the runs to fit on.
fn offset_of_run(run: usize) -> Parameter {
    Parameter {
        name: format!("position_offset_m of run {}", run + 1),
        start: 0.0,
        lower: -track_offset::LARGEST_M,
        upper: track_offset::LARGEST_M,
        scale: track_offset::SCALE_M,
        prior_mean: 0.0,
        prior_sigma: track_offset::SIGMA_M,
        run: Some(run),
        shows_in: None,
    }
}

/// Half width of the range of a mass of which the vehicle file says nothing, relative.
const MASS_HALF_RANGE: f64 = 0.015;

/// Builds an effect from fitted values.
pub type Builder = Arc<dyn Fn(&[f64]) -> Box<dyn Effect> + Send + Sync>;

/// An effect whose continuous parameters are fitted.
#[derive(Clone)]
pub struct FittedEffect {
    /// Its entry in the catalogue, or of a flexible discrepancy.
    pub spec: &'static EffectSpec,
    /// Values of the discrete parameters, by index; NaN where continuous.
    pub fixed: Vec<f64>,
    /// The continuous parameters.
    pub parameters: Vec<Parameter>,
    builder: Builder,
    /// Whether the recordings were put right for it, see [`Shape::on_recordings`].
    aligned: bool,
}

impl std::fmt::Debug for FittedEffect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FittedEffect").field("id", &self.spec.id).field("fixed", &self.fixed).finish()
    }
}

impl FittedEffect {
    /// An effect of the catalogue with these values (discrete ones stay fixed, the others are where the fit starts).
    pub fn of_catalogue(spec: &'static EffectSpec, constructor: Constructor, start: &[f64]) -> Self {
        let mut fixed = vec![f64::NAN; spec.parameters.len()];
        let mut parameters = Vec::new();
        for (i, p) in spec.parameters.iter().enumerate() {
            if p.discrete {
                fixed[i] = start[i];
                continue;
            }
            let away = p.default - p.neutral.unwrap_or(0.0);
            let far = if away != 0.0 { away.abs() } else { 0.01 * (p.upper - p.lower) };
            let scale = p.scale.unwrap_or(far);
            parameters.push(Parameter {
                name: p.name.into(),
                start: start[i],
                lower: p.lower,
                upper: p.upper,
                scale,
                prior_mean: p.default,
                prior_sigma: p.prior_sigma,
                run: None,
                shows_in: None,
            });
        }
        let held = fixed.clone();
        let builder = move |values: &[f64]| constructor(&merge(&held, values));
        Self { spec, fixed, parameters, builder: Arc::new(builder), aligned: false }
    }

    /// This effect at positions that each of so many runs shows shifted by an offset of its own, see
    /// [`track_offset`](crate::model::track_offset). The offsets come after the parameters of the spec.
    pub fn with_track_offsets(&self, runs: usize) -> Self {
        let mut shifted = self.clone();
        let own = shifted.parameters.len();
        shifted.parameters.extend((0..runs).map(offset_of_run));
        let inner = Arc::clone(&self.builder);
        shifted.builder = Arc::new(move |values: &[f64]| {
            let (own, offsets_m) = values.split_at(own.min(values.len()));
            Box::new(track_offset::Shifted::new(inner(own), offsets_m.to_vec()))
        });
        shifted
    }

    /// This effect on a stretch that lies on the track `from` to `to`, m, and is not much longer than stretches are.
    pub(crate) fn within_track(mut self, (from, to): (f64, f64)) -> Self {
        let longest = track_offset::LONGEST_M.min(track_offset::LONGEST_SHARE * (to - from));
        for parameter in &mut self.parameters {
            match parameter.name.as_str() {
                "start_m" => (parameter.lower, parameter.upper) = (parameter.lower.max(from - 50.0), to),
                "length_m" => parameter.upper = parameter.upper.min(longest),
                _ => continue,
            }
            parameter.start = parameter.start.clamp(parameter.lower, parameter.upper.max(parameter.lower));
            parameter.upper = parameter.upper.max(parameter.lower);
        }
        self
    }

    /// The continuous parameters of its spec, without offsets of single runs.
    pub fn own_parameters(&self) -> usize {
        self.parameters.iter().filter(|parameter| parameter.run.is_none()).count()
    }

    /// A flexible discrepancy.
    pub fn custom(spec: &'static EffectSpec, parameters: Vec<Parameter>, builder: Builder) -> Self {
        Self { spec, fixed: vec![f64::NAN; parameters.len()], parameters, builder, aligned: false }
    }

    /// The effect at these values.
    pub fn build(&self, continuous: &[f64]) -> Box<dyn Effect> {
        (self.builder)(continuous)
    }

    /// Whether it is not part of the model since the recordings were put right for it.
    pub fn is_aligned(&self) -> bool {
        self.aligned
    }

    /// This effect as one for which the recordings are put right, at `values`, each known to so many `sigmas`.
    pub fn aligned(&self, values: &[f64], sigmas: &[f64]) -> Self {
        let mut aligned = self.clone();
        aligned.aligned = true;
        for (parameter, (value, sigma)) in aligned.parameters.iter_mut().zip(values.iter().zip(sigmas)) {
            (parameter.start, parameter.prior_mean, parameter.prior_sigma) = (*value, *value, *sigma);
        }
        aligned
    }

    /// All parameter values in the order of the spec.
    pub fn values(&self, continuous: &[f64]) -> Vec<f64> {
        merge(&self.fixed, continuous)
    }
}

fn merge(fixed: &[f64], continuous: &[f64]) -> Vec<f64> {
    let mut rest = continuous.iter();
    fixed.iter().map(|&v| if v.is_nan() { rest.next().copied().unwrap_or(f64::NAN) } else { v }).collect()
}

/// The shape of a model: nominal vehicle, nuisances of the case, effects.
#[derive(Clone, Debug)]
pub struct Shape {
    vehicle: VehicleParameters,
    nuisances: Vec<Nuisance>,
    /// The effects in the order in which they act.
    pub effects: Vec<FittedEffect>,
    parameters: Vec<Parameter>,
}

/// A model with numbers in it.
#[derive(Clone, Debug)]
pub struct Built {
    /// The wagon.
    pub model: WagonModel,
    /// μ0 of each of [`RailClass::OF_RECORDINGS`].
    pub adhesion: [f64; 4],
}

impl Built {
    /// μ0 of a class of rail.
    pub fn adhesion(&self, class: RailClass) -> f64 {
        self.adhesion[class as usize]
    }
}

impl Shape {
    /// The nominal model with the nuisances that runs of this case can show.
    pub fn nominal(case: &Case) -> Self {
        let mut nuisances: Vec<Nuisance> = (0..case.wheelsets()).map(Nuisance::Pad).collect();
        let present = |class| case.fit.iter().chain(&case.holdout).any(|run| run.rail == class);
        let classes = RailClass::OF_RECORDINGS.into_iter().filter(|class| present(*class));
        nuisances.extend(classes.map(Nuisance::Adhesion));
        nuisances.extend([Nuisance::ResistanceConstant, Nuisance::Drag, Nuisance::Mass, Nuisance::Inertia]);
        nuisances.extend([Nuisance::Stiffness, Nuisance::CreepTail]);
        let parameter = |nuisance: &Nuisance| {
            let of = |class| {
                let runs = case.fit.iter().enumerate().filter(move |(_, run)| run.rail == class);
                runs.map(|(index, _)| index).collect()
            };
            let shows_in = match nuisance {
                Nuisance::Adhesion(class) => Some(of(*class)),
                _ => None,
            };
            Parameter { shows_in, ..nuisance.parameter(&case.vehicle) }
        };
        let parameters = nuisances.iter().map(parameter).collect();
        Self { vehicle: case.vehicle.clone(), nuisances, effects: Vec::new(), parameters }
    }

    /// This shape with one more effect.
    pub fn with(&self, effect: &FittedEffect) -> Self {
        let mut more = self.clone();
        more.parameters.extend(effect.parameters.iter().cloned());
        more.effects.push(effect.clone());
        more
    }

    /// This shape with these effects alone.
    pub fn with_all(&self, effects: &[FittedEffect]) -> Self {
        effects.iter().fold(self.bare(), |shape, effect| shape.with(effect))
    }

    /// This shape without one of its effects, and what is left of `theta`.
    pub fn without(&self, theta: &[f64], effect: usize) -> (Self, Vec<f64>) {
        let others = self.effects.iter().enumerate().filter(|(e, _)| *e != effect);
        let others: Vec<FittedEffect> = others.map(|(_, effect)| effect.clone()).collect();
        let own = self.range_of(effect);
        let rest = theta.iter().enumerate().filter(|(i, _)| !own.contains(i)).map(|(_, value)| *value);
        (self.with_all(&others), rest.collect())
    }

    /// This shape on the recordings as they are, where effects for which they were put right act in the model again. The
    /// parameters keep their places.
    pub fn on_recordings(&self) -> Self {
        let mut plain = self.clone();
        for effect in plain.effects.iter_mut().filter(|effect| effect.aligned) {
            effect.aligned = false;
            let of_spec = |p: &Parameter| effect.spec.parameters.iter().find(|spec| spec.name == p.name);
            for parameter in &mut effect.parameters {
                if let Some(spec) = of_spec(parameter) {
                    (parameter.prior_mean, parameter.prior_sigma) = (spec.default, spec.prior_sigma);
                }
            }
        }
        self.bare().with_all(&plain.effects)
    }

    /// This shape without effects.
    pub fn bare(&self) -> Self {
        let mut bare = self.clone();
        bare.parameters.truncate(self.nuisances.len());
        bare.effects.clear();
        bare
    }

    /// Fitted numbers: nuisances first, then each effect's.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Number of nuisances.
    pub fn nuisance_count(&self) -> usize {
        self.nuisances.len()
    }

    /// Where a fit starts.
    pub fn start(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.start).collect()
    }

    /// Range of an effect's own parameters.
    pub fn range_of(&self, effect: usize) -> std::ops::Range<usize> {
        let before: usize = self.effects[..effect].iter().map(|e| e.parameters.len()).sum();
        let from = self.nuisances.len() + before;
        from..from + self.effects[effect].parameters.len()
    }

    /// The same of the last effect; empty without effects.
    pub fn range_of_last(&self) -> std::ops::Range<usize> {
        match self.effects.len() {
            0 => 0..0,
            number => self.range_of(number - 1),
        }
    }

    /// The vehicle with the nuisances of `theta`.
    pub fn vehicle(&self, theta: &[f64]) -> (VehicleParameters, PerWheelset) {
        let mut vehicle = self.vehicle.clone();
        let mut pads = [1.0; MAX_WHEELSETS];
        for (nuisance, value) in self.nuisances.iter().zip(theta) {
            let factor = 1.0 + value;
            match nuisance {
                Nuisance::Pad(i) => pads[*i] *= factor,
                Nuisance::Adhesion(RailClass::Dry) => vehicle.rail.dry *= factor,
                Nuisance::Adhesion(RailClass::Wet) => vehicle.rail.wet *= factor,
                Nuisance::Adhesion(RailClass::Low) => vehicle.rail.low *= factor,
                // A vehicle file has no place for it.
                Nuisance::Adhesion(RailClass::Undeclared) => {}
                Nuisance::ResistanceConstant => vehicle.resistance.constant_n *= factor,
                Nuisance::Drag => vehicle.resistance.drag_n_s2_per_m2 *= factor,
                Nuisance::Mass => vehicle.body.mass_kg *= factor,
                Nuisance::Inertia => vehicle.wheelset.inertia_kg_m2 *= factor,
                Nuisance::Stiffness => vehicle.contact.stiffness_n *= factor,
                Nuisance::CreepTail => vehicle.contact.k_s *= factor,
            }
        }
        (vehicle, pads)
    }

    /// μ0 of runs whose names declare no rail: from the nominal one of dry rail on, whatever rail declared dry has.
    fn undeclared_adhesion(&self, theta: &[f64]) -> f64 {
        let undeclared = Nuisance::Adhesion(RailClass::Undeclared);
        let change = self.nuisances.iter().zip(theta).find(|(nuisance, _)| **nuisance == undeclared);
        self.vehicle.rail.dry * (1.0 + change.map_or(0.0, |(_, value)| *value))
    }

    /// The model at `theta`.
    pub fn build(&self, theta: &[f64]) -> Built {
        let (vehicle, pads) = self.vehicle(theta);
        // Effects that the file itself names are part of the nominal model.
        let own = vehicle.effects.iter().filter_map(|entry| railgrip_vehicle::effects::build(entry).ok());
        let acting = (0..self.effects.len()).filter(|e| !self.effects[*e].aligned);
        let found = acting.map(|e| self.effects[e].build(&theta[self.range_of(e)]));
        let effects = own.chain(found).collect();
        let mut constants = Constants::of(&vehicle);
        for (level, factor) in constants.brake_friction.iter_mut().zip(pads) {
            *level *= factor;
        }
        let model = WagonModel::from_constants(constants, effects);
        let mut adhesion = RailClass::OF_RECORDINGS.map(|class| vehicle.rail.adhesion(class));
        adhesion[RailClass::Undeclared as usize] = self.undeclared_adhesion(theta);
        Built { model, adhesion }
    }
}
