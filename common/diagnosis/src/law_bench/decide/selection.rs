//! Which candidates explain the gap: every one refitted with the nuisances, ranked by what it predicts of left-out data, set
//! against chance, added one by one and removed again where the others make it superfluous.

use super::chance::{Chance, Supposed};
use super::criteria::Criteria;
use crate::law_bench::data::case::{Kind, Nominal};
use crate::law_bench::data::point::Point;
use crate::law_bench::fit::fitted::FittedModel;
use crate::law_bench::fit::left_out::Folds;
use crate::law_bench::fit::noise::Noise;
use crate::law_bench::fit::solver::{Fit, fit_from, fit_once, on_bound};
use crate::law_bench::model::candidates::{CandidateSpec, Form};
use crate::law_bench::model::discrepancy::{Tangent, discrepancies};
use crate::law_bench::model::law::Model;
use crate::law_bench::model::shape::Shape;
use rayon::prelude::*;

/// Added to the seed where a further effect is set against chance beside splines, so that it has random numbers of its own.
const SPLINE_ROUND: u64 = 99;

/// What a search works on.
pub struct Search<'a> {
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
    /// Seed of the simulated noise.
    pub seed: u64,
    /// The thresholds.
    pub criteria: &'a Criteria,
}

/// A candidate on top of a model.
#[derive(Clone, Debug)]
pub struct CandidateScore {
    /// The candidate.
    pub spec: &'static CandidateSpec,
    /// The model with it.
    pub fitted: FittedModel,
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

/// What was selected.
pub struct Selection {
    /// Every candidate alone, best first.
    pub alone: Vec<CandidateScore>,
    /// Chance for a single candidate.
    pub chance: Chance,
    /// The extended model.
    pub extended: FittedModel,
    /// Effects of the extended model, strongest first, each with the rivals that could stand in its place.
    pub effects: Vec<SelectedEffect>,
}

/// An effect of the extended model.
#[derive(Clone, Debug)]
pub struct SelectedEffect {
    /// The candidate.
    pub spec: &'static CandidateSpec,
    /// Index of its form in the extended model.
    pub form: usize,
    /// Score that would be lost without it.
    pub worth: f64,
    /// Candidates in its place: id and how much worse they rank.
    pub rivals: Vec<(&'static CandidateSpec, f64)>,
    /// Probability that chance scores as well.
    pub p_value: f64,
}

impl Search<'_> {
    fn price(&self, form: &Form) -> f64 {
        form.shape().parameters() as f64 * (self.points.len() as f64).ln()
    }

    /// Fits a model from `starts` and predicts left-out data.
    pub fn fit(&self, model: Model, starts: &[Vec<f64>]) -> Option<FittedModel> {
        let fit = fit_from(&model, self.points, self.noise.sigma, starts)?;
        let left_out = self.folds.errors(&model, self.points, self.noise.sigma, &fit.values);
        Some(FittedModel { model, fit, left_out })
    }

    /// The model without effects.
    pub fn calibrated(&self) -> FittedModel {
        let model = Model::new(self.nominal, &[]);
        let start = model.nominal_values();
        let fit = fit_once(&model, self.points, self.noise.sigma, &start);
        let left_out = self.folds.errors(&model, self.points, self.noise.sigma, &fit.values);
        FittedModel { model, fit, left_out }
    }

    /// `spec` on top of `base`, in its best form.
    fn add(&self, base: &FittedModel, spec: &'static CandidateSpec) -> Option<CandidateScore> {
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
            let margin = if best.is_some() && form.index > 0 { self.criteria.form_margin } else { 0.0 };
            if best.as_ref().is_none_or(|(_, _, known)| score > known + margin) {
                best = Some((model, fit, score));
            }
        }
        let (model, fit, score) = best?;
        let left_out = self.folds.errors(&model, self.points, self.noise.sigma, &fit.values);
        Some(self.scored(base, spec, FittedModel { model, fit, left_out }, score))
    }

    fn scored(
        &self,
        base: &FittedModel,
        spec: &'static CandidateSpec,
        fitted: FittedModel,
        score: f64,
    ) -> CandidateScore {
        let total: f64 = base.left_out.iter().sum();
        let gains: Vec<f64> = base.left_out.iter().zip(&fitted.left_out).map(|(b, f)| b - f).collect();
        let gain: f64 = gains.iter().sum();
        let mean = gain / gains.len() as f64;
        let variance =
            gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (gains.len().max(2) - 1) as f64;
        let on_bound = on_bound(&fitted.model, &fitted.fit.values);
        CandidateScore {
            spec,
            score,
            rank: 0.5 * (score + gain / self.noise.unit()),
            cv_gain: gain / total.max(1e-12),
            cv_spread: 2.0 * (variance * gains.len() as f64).sqrt() / total.max(1e-12),
            p_value: 1.0,
            on_bound,
            fitted,
        }
    }

    fn chance(&self, base: &FittedModel, library: &[&'static CandidateSpec], round: u64) -> Chance {
        let values = &base.fit.values;
        let tangent = Tangent::of(&base.model, self.points, values, self.noise.sigma);
        let smooth = discrepancies(self.kind, self.points, &tangent);
        let forms: Vec<Form> = library.iter().flat_map(|spec| spec.forms_on(self.points)).collect();
        let supposed = self.supposed(base, &tangent);
        Chance::of(&supposed, &forms, &smooth, self.criteria, self.seed.wrapping_add(round))
    }

    /// `fitted` as the model beyond which nothing is supposed to be missing.
    pub fn supposed<'b>(&'b self, fitted: &'b FittedModel, tangent: &'b Tangent) -> Supposed<'b> {
        Supposed {
            model: &fitted.model,
            values: &fitted.fit.values,
            nominal: self.nominal,
            points: self.points,
            noise: self.noise,
            tangent,
        }
    }

    /// Every candidate of `library` on top of `base`, best first.
    fn round(
        &self,
        base: &FittedModel,
        library: &[&'static CandidateSpec],
        chance: &Chance,
    ) -> Vec<CandidateScore> {
        let mut all: Vec<CandidateScore> =
            library.par_iter().filter_map(|spec| self.add(base, spec)).collect();
        for scored in &mut all {
            scored.p_value = chance.p_library(scored.score);
        }
        all.sort_by(|a, b| b.rank.total_cmp(&a.rank));
        all
    }

    /// Selects effects on top of the calibrated model.
    pub fn select(&self, calibrated: &FittedModel) -> Selection {
        let chance = self.chance(calibrated, &self.library, 0);
        let alone = self.round(calibrated, &self.library, &chance);
        let mut extended = calibrated.clone();
        let mut selected: Vec<&'static CandidateSpec> = Vec::new();
        let mut candidates: Vec<CandidateScore> = alone.clone();
        let mut first_score = 0.0;
        while selected.len() < self.criteria.most_effects {
            let accepted = candidates.iter().find(|scored| {
                scored.p_value < self.criteria.library_level
                    && scored.cv_gain > 0.0
                    && scored.score > self.criteria.material_share * first_score
                    && (selected.is_empty() || self.survives_splines(&extended, scored.spec))
            });
            let Some(accepted) = accepted else { break };
            if selected.is_empty() {
                first_score = accepted.score;
            }
            selected.push(accepted.spec);
            extended = self.refine(accepted.fitted.clone());
            let left: Vec<_> = self.library.iter().copied().filter(|spec| !selected.contains(spec)).collect();
            if left.is_empty() {
                break;
            }
            let round = self.chance(&extended, &left, selected.len() as u64);
            candidates = self.round(&extended, &left, &round);
        }
        let extended = self.prune(calibrated, extended);
        let effects = self.explain(calibrated, &extended, &chance);
        Selection { alone, chance, extended, effects }
    }

    /// Whether a further candidate still counts when the effects before it may bend as they like: else it only mends their form.
    fn survives_splines(&self, base: &FittedModel, spec: &'static CandidateSpec) -> bool {
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
        let Some(flexible) = self.fit(model, &[start]) else { return true };
        if flexible.fit.cost > base.fit.cost {
            return true;
        }
        let chance = self.chance(&flexible, &[spec], SPLINE_ROUND);
        self.add(&flexible, spec)
            .is_some_and(|scored| chance.p_library(scored.score) < self.criteria.library_level)
    }

    /// Lets every effect of a model take the form that fits best beside the others.
    fn refine(&self, fitted: FittedModel) -> FittedModel {
        let mut best = fitted;
        for index in 0..best.model.forms().len() {
            let spec = best.model.forms()[index].spec;
            let Some(others) = self.without(&best, index) else { continue };
            let Some(again) = self.add(&others, spec) else { continue };
            if again.fitted.fit.cost < best.fit.cost - self.noise.unit() * self.criteria.form_margin {
                best = again.fitted;
            }
        }
        best
    }

    /// The model refitted without its form `index`.
    fn without(&self, fitted: &FittedModel, index: usize) -> Option<FittedModel> {
        let mut forms = fitted.model.forms().to_vec();
        let removed = forms.remove(index);
        let start = fitted.model.offset(index);
        let mut values = fitted.fit.values.clone();
        values.drain(start..start + removed.shape().parameters());
        self.fit(Model::new(self.nominal, &forms), &[values])
    }

    /// Deletes effects that the others make superfluous.
    fn prune(&self, calibrated: &FittedModel, mut fitted: FittedModel) -> FittedModel {
        while fitted.model.forms().len() > 1 {
            let losses = (0..fitted.model.forms().len()).filter_map(|index| {
                let reduced = self.without(&fitted, index)?;
                let price = self.price(&fitted.model.forms()[index]);
                Some(((reduced.fit.cost - fitted.fit.cost) / self.noise.unit() - price, reduced))
            });
            let weakest = losses.min_by(|a, b| a.0.total_cmp(&b.0));
            let explained = (calibrated.fit.cost - fitted.fit.cost) / self.noise.unit();
            match weakest {
                Some((loss, reduced))
                    if loss
                        < f64::max(self.criteria.least_worth, self.criteria.material_share * explained) =>
                {
                    fitted = reduced
                }
                _ => break,
            }
        }
        fitted
    }

    /// The effects of the extended model, strongest first, with their rivals.
    fn explain(
        &self,
        calibrated: &FittedModel,
        extended: &FittedModel,
        chance: &Chance,
    ) -> Vec<SelectedEffect> {
        let count = extended.model.forms().len();
        let mut effects: Vec<SelectedEffect> = (0..count)
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
                Some(SelectedEffect { spec, form: index, worth: own.score, rivals, p_value })
            })
            .collect();
        effects.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        effects
    }
}
