//! Which candidates explain the gap: every one refitted with the nuisances, ranked by what it predicts of left-out data, set
//! against chance, chosen forward and deleted backward.

use super::chance::{Chance, Noise};
use super::fit::{Fit, fit_from, fit_once, on_bound};
use super::flexible::{Tangent, groups};
use super::folds::Folds;
use super::forms::Shape;
use super::input::{Kind, Nominal};
use super::library::{CandidateSpec, Form};
use super::model::Model;
use super::points::Point;
use rayon::prelude::*;

/// Probability of naming an effect where there is none.
pub const LIBRARY_LEVEL: f64 = 0.04;

/// Probability of calling for an unknown effect where there is none; both levels add up to 5 %.
pub const FLEXIBLE_LEVEL: f64 = 0.01;

/// Most effects that are named at once.
const MOST_EFFECTS: usize = 3;

/// A further effect must explain this share of what the first one did.
const MATERIAL_SHARE: f64 = 0.005;

/// Score by which a form must beat the candidate's preferred one.
const FORM_MARGIN: f64 = 6.0;

/// What a search works on.
pub struct Bench<'a> {
    /// Which law.
    pub kind: Kind,
    /// What the simulator believes.
    pub nominal: Nominal,
    /// Points to fit on.
    pub points: &'a [Point],
    /// Noise of the measured column.
    pub noise: Noise,
    /// Candidates that the data can show.
    pub library: Vec<&'static CandidateSpec>,
    /// Left-out data.
    pub folds: Folds,
    /// Seed of the bootstraps.
    pub seed: u64,
}

/// A fitted model, and its errors on left-out data.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The model.
    pub model: Model,
    /// Its fit.
    pub fit: Fit,
    /// Squared errors on left-out data by fold.
    pub left_out: Vec<f64>,
}

/// A candidate on top of a model.
#[derive(Clone, Debug)]
pub struct Scored {
    /// The candidate.
    pub spec: &'static CandidateSpec,
    /// The model with it.
    pub trial: Trial,
    /// Squared error removed on the fit points, less the price of its parameters.
    pub score: f64,
    /// The mean of `score` and of the squared error removed on left-out data.
    pub rank: f64,
    /// Share of the squared error removed on left-out data.
    pub cv_gain: f64,
    /// Two standard errors of `cv_gain` over the folds.
    pub cv_spread: f64,
    /// Probability that the best of the library scores as well under no effect.
    pub p_value: f64,
    /// Names of parameters on a bound.
    pub on_bound: Vec<&'static str>,
}

/// What a search found.
pub struct Found {
    /// Every candidate alone, best first.
    pub alone: Vec<Scored>,
    /// Chance for a single candidate.
    pub chance: Chance,
    /// The extended model.
    pub extended: Trial,
    /// Effects of the extended model, strongest first, each with the rivals that could stand in its place.
    pub effects: Vec<Chosen>,
}

/// An effect of the extended model.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The candidate.
    pub spec: &'static CandidateSpec,
    /// Index of its form in the extended model.
    pub form: usize,
    /// Score that would be lost without it.
    pub loss: f64,
    /// Candidates in its place: id and how much worse they rank.
    pub rivals: Vec<(&'static CandidateSpec, f64)>,
    /// Probability that chance scores as well.
    pub p_value: f64,
}

impl Bench<'_> {
    fn price(&self, form: &Form) -> f64 {
        form.shape().parameters() as f64 * (self.points.len() as f64).ln()
    }

    /// Fits a model from `starts` and predicts left-out data.
    pub fn trial(&self, model: Model, starts: &[Vec<f64>]) -> Option<Trial> {
        let fit = fit_from(&model, self.points, self.noise.sigma, starts)?;
        let left_out = self.folds.errors(&model, self.points, self.noise.sigma, &fit.values);
        Some(Trial { model, fit, left_out })
    }

    /// The model without effects.
    pub fn calibrated(&self) -> Trial {
        let model = Model::new(self.nominal, &[]);
        let start = model.nominal_values();
        let fit = fit_once(&model, self.points, self.noise.sigma, &start);
        let left_out = self.folds.errors(&model, self.points, self.noise.sigma, &fit.values);
        Trial { model, fit, left_out }
    }

    /// `spec` on top of `base`, in its best form.
    fn add(&self, base: &Trial, spec: &'static CandidateSpec) -> Option<Scored> {
        let mut best: Option<(Model, Fit, f64)> = None;
        for form in spec.forms_on(self.points) {
            let mut forms = base.model.forms().to_vec();
            forms.push(form);
            let model = Model::new(self.nominal, &forms);
            let starts: Vec<Vec<f64>> = form
                .shape()
                .starts(&form.scale)
                .into_iter()
                .map(|own| base.fit.values.iter().copied().chain(own).collect())
                .collect();
            let Some(fit) = fit_from(&model, self.points, self.noise.sigma, &starts) else { continue };
            let score = (base.fit.cost - fit.cost) / self.noise.unit() - self.price(&form);
            let margin = if best.is_some() && form.index > 0 { FORM_MARGIN } else { 0.0 };
            if best.as_ref().is_none_or(|(_, _, known)| score > known + margin) {
                best = Some((model, fit, score));
            }
        }
        let (model, fit, score) = best?;
        let left_out = self.folds.errors(&model, self.points, self.noise.sigma, &fit.values);
        Some(self.scored(base, spec, Trial { model, fit, left_out }, score))
    }

    fn scored(&self, base: &Trial, spec: &'static CandidateSpec, trial: Trial, score: f64) -> Scored {
        let total: f64 = base.left_out.iter().sum();
        let gains: Vec<f64> = base.left_out.iter().zip(&trial.left_out).map(|(b, t)| b - t).collect();
        let gain: f64 = gains.iter().sum();
        let mean = gain / gains.len() as f64;
        let variance =
            gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (gains.len().max(2) - 1) as f64;
        let on_bound = on_bound(&trial.model, &trial.fit.values);
        Scored {
            spec,
            score,
            rank: 0.5 * (score + gain / self.noise.unit()),
            cv_gain: gain / total.max(1e-12),
            cv_spread: 2.0 * (variance * gains.len() as f64).sqrt() / total.max(1e-12),
            p_value: 1.0,
            on_bound,
            trial,
        }
    }

    fn chance(&self, base: &Trial, library: &[&'static CandidateSpec], round: u64) -> Chance {
        let values = &base.fit.values;
        let tangent = Tangent::of(&base.model, self.points, values, self.noise.sigma);
        let flexible = groups(self.kind, self.points, &tangent);
        let forms: Vec<Form> = library.iter().flat_map(|spec| spec.forms_on(self.points)).collect();
        Chance::of(
            &base.model,
            self.points,
            values,
            &self.noise,
            &forms,
            &flexible,
            &tangent,
            &self.nominal,
            self.seed.wrapping_add(round),
        )
    }

    /// Every candidate of `library` on top of `base`, best first.
    fn round(&self, base: &Trial, library: &[&'static CandidateSpec], chance: &Chance) -> Vec<Scored> {
        let mut all: Vec<Scored> = library.par_iter().filter_map(|spec| self.add(base, spec)).collect();
        for scored in &mut all {
            scored.p_value = chance.p_library(scored.score);
        }
        all.sort_by(|a, b| b.rank.total_cmp(&a.rank));
        all
    }

    /// Chooses effects.
    pub fn search(&self, calibrated: &Trial) -> Found {
        let chance = self.chance(calibrated, &self.library, 0);
        let alone = self.round(calibrated, &self.library, &chance);
        let mut extended = calibrated.clone();
        let mut chosen: Vec<&'static CandidateSpec> = Vec::new();
        let mut candidates: Vec<Scored> = alone.clone();
        let mut first_score = 0.0;
        while chosen.len() < MOST_EFFECTS {
            let level = LIBRARY_LEVEL;
            let accepted = candidates.iter().find(|scored| {
                scored.p_value < level
                    && scored.cv_gain > 0.0
                    && scored.score > MATERIAL_SHARE * first_score
                    && (chosen.is_empty() || self.survives_splines(&extended, scored.spec))
            });
            let Some(accepted) = accepted else { break };
            if chosen.is_empty() {
                first_score = accepted.score;
            }
            chosen.push(accepted.spec);
            extended = self.refine(accepted.trial.clone());
            let left: Vec<_> = self.library.iter().copied().filter(|spec| !chosen.contains(spec)).collect();
            if left.is_empty() {
                break;
            }
            let round = self.chance(&extended, &left, chosen.len() as u64);
            candidates = self.round(&extended, &left, &round);
        }
        let extended = self.prune(calibrated, extended);
        let effects = self.explain(calibrated, &extended, &chance);
        Found { alone, chance, extended, effects }
    }

    /// Whether a further candidate still counts when the effects before it may bend as they like: else it only mends their form.
    fn survives_splines(&self, base: &Trial, spec: &'static CandidateSpec) -> bool {
        let forms: Vec<Form> = base
            .model
            .forms()
            .iter()
            .map(|form| {
                let spline = form.spec.forms_on(self.points).into_iter().find(|f| f.shape() == Shape::Spline);
                spline.unwrap_or(*form)
            })
            .collect();
        let model = Model::new(self.nominal, &forms);
        let mut start = base.fit.values[..base.model.nuisances()].to_vec();
        for (index, form) in forms.iter().enumerate() {
            if form.index == base.model.forms()[index].index {
                start.extend_from_slice(base.model.values_of(index, &base.fit.values));
            } else {
                start.extend([-0.1, 0.0, 0.0]);
            }
        }
        let Some(flexible) = self.trial(model, &[start]) else { return true };
        if flexible.fit.cost > base.fit.cost {
            return true;
        }
        let chance = self.chance(&flexible, &[spec], 99);
        self.add(&flexible, spec).is_some_and(|scored| chance.p_library(scored.score) < LIBRARY_LEVEL)
    }

    /// Lets every effect of a model take the form that fits best beside the others.
    fn refine(&self, trial: Trial) -> Trial {
        let mut best = trial;
        for index in 0..best.model.forms().len() {
            let spec = best.model.forms()[index].spec;
            let Some(others) = self.without(&best, index) else { continue };
            let Some(again) = self.add(&others, spec) else { continue };
            if again.trial.fit.cost < best.fit.cost - self.noise.unit() * FORM_MARGIN {
                best = again.trial;
            }
        }
        best
    }

    /// The model refitted without its form `index`.
    fn without(&self, trial: &Trial, index: usize) -> Option<Trial> {
        let mut forms = trial.model.forms().to_vec();
        let removed = forms.remove(index);
        let start = trial.model.offset(index);
        let mut values = trial.fit.values.clone();
        values.drain(start..start + removed.shape().parameters());
        self.trial(Model::new(self.nominal, &forms), &[values])
    }

    /// Deletes effects that the others make superfluous.
    fn prune(&self, calibrated: &Trial, mut trial: Trial) -> Trial {
        while trial.model.forms().len() > 1 {
            let losses = (0..trial.model.forms().len()).filter_map(|index| {
                let reduced = self.without(&trial, index)?;
                let price = self.price(&trial.model.forms()[index]);
                Some(((reduced.fit.cost - trial.fit.cost) / self.noise.unit() - price, reduced))
            });
            let weakest = losses.min_by(|a, b| a.0.total_cmp(&b.0));
            let explained = (calibrated.fit.cost - trial.fit.cost) / self.noise.unit();
            match weakest {
                Some((loss, reduced)) if loss < f64::max(4.0, MATERIAL_SHARE * explained) => trial = reduced,
                _ => break,
            }
        }
        trial
    }

    /// The effects of the extended model, strongest first, with their rivals.
    fn explain(&self, calibrated: &Trial, extended: &Trial, chance: &Chance) -> Vec<Chosen> {
        let count = extended.model.forms().len();
        let mut effects: Vec<Chosen> = (0..count)
            .filter_map(|index| {
                let spec = extended.model.forms()[index].spec;
                let others = if count == 1 { calibrated.clone() } else { self.without(extended, index)? };
                let own = self.add(&others, spec)?;
                let used: Vec<&str> = extended.model.forms().iter().map(|form| form.spec.id).collect();
                let left: Vec<_> =
                    self.library.iter().copied().filter(|rival| !used.contains(&rival.id)).collect();
                let mut rivals: Vec<(&'static CandidateSpec, f64)> = left
                    .par_iter()
                    .filter_map(|rival| Some((*rival, own.rank - self.add(&others, rival)?.rank)))
                    .collect();
                rivals.sort_by(|a, b| a.1.total_cmp(&b.1));
                let p_value = chance.p_library(own.score);
                Some(Chosen { spec, form: index, loss: own.score, rivals, p_value })
            })
            .collect();
        effects.sort_by(|a, b| b.loss.total_cmp(&a.loss));
        effects
    }
}
