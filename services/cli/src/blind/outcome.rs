//! What became of one case, and how often things were right.

use serde::Serialize;

use super::{
    answer::{Answer, Named},
    make::{Made, VISIBLE},
    rankings::Rankings,
};

/// A case with its answer.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Outcome {
    /// The case and its label.
    pub made: Made,
    /// What was said; `None` if the diagnosis failed.
    pub answer: Option<Answer>,
    /// Holdout gap of the calibrated nominal model on the twin.
    pub floor: Option<f64>,
    /// Whether the stated holdout gaps follow from the prediction files.
    pub verified: Option<Result<(), String>>,
    /// Wall-clock time of the diagnosis, s.
    pub seconds: f64,
    /// Why there is no answer.
    pub failure: Option<String>,
    /// What mere rankings would have said.
    pub rankings: Rankings,
}

impl Outcome {
    /// What sort of case it is.
    pub(super) fn kind(&self) -> &'static str {
        match (self.made.label.effects.as_slice(), &self.made.withheld) {
            ([], _) => "none",
            (_, Some(_)) => "withheld",
            _ if self.made.is_unknown() => "nameless",
            ([_], _) => "single",
            ([_, _], _) => "pair",
            _ => "triple",
        }
    }

    /// Effects that were named, strongest first.
    pub(super) fn effects(&self) -> &[Named] {
        self.answer.as_ref().map_or(&[], |answer| &answer.effects)
    }

    /// Whether there is anything to see: the calibrated gap is above the twin's by a tenth.
    pub(super) fn is_visible(&self) -> bool {
        self.made.label.effects.is_empty() || self.made.label.salience() >= VISIBLE
    }

    /// Whether the calibration that was diagnosed leaves a gap of so many times the floor, too: one with other freedom may take an
    /// effect up.
    pub(super) fn is_left_by_calibration(&self, times: f64) -> bool {
        let floor = self.made.label.gap_without_the_effect.fit;
        self.answer.as_ref().is_some_and(|answer| answer.calibrated_fit >= times * floor)
    }

    pub(super) fn says_none(&self) -> bool {
        self.answer.as_ref().is_some_and(|answer| answer.verdict == "none")
    }

    pub(super) fn says_unknown(&self) -> bool {
        self.answer.as_ref().is_some_and(|answer| answer.verdict.contains("unknown"))
    }

    pub(super) fn true_terms(&self) -> Vec<&str> {
        self.made.label.effects.iter().map(|effect| effect.term.as_str()).collect()
    }

    /// The term that the report blames first.
    pub(super) fn first_term(&self) -> Option<&str> {
        let answer = self.answer.as_ref()?;
        answer.effects.first().map(|effect| effect.term.as_str()).or(answer.term.as_deref())
    }

    /// Whether the term is right; for an unknown the location or the term of the rest counts.
    pub(super) fn term_is_right(&self) -> bool {
        let truth = self.true_terms();
        let Some(answer) = &self.answer else { return false };
        if self.made.is_unknown() {
            return [&answer.term, &answer.unexplained_term]
                .into_iter()
                .flatten()
                .any(|t| truth.contains(&t.as_str()));
        }
        self.first_term().is_some_and(|term| truth.contains(&term))
    }

    /// Whether the answer counts as right.
    pub(super) fn is_right(&self) -> bool {
        let nameable = self.made.nameable();
        match nameable.as_slice() {
            // Of what nobody can see, nothing need be said.
            _ if !self.is_visible() && self.says_none() => true,
            _ if self.made.is_unknown() => self.says_unknown(),
            [] => self.says_none(),
            [id] => self.effects().first().is_some_and(|named| named.is(id)),
            _ => self.all_are_named(),
        }
    }

    /// Whether the first name is one of the effects that can be named.
    pub(super) fn first_is_right(&self) -> bool {
        let nameable = self.made.nameable();
        self.effects().first().is_some_and(|named| nameable.iter().any(|id| named.is(id)))
    }

    /// Whether every effect that can be named is named.
    pub(super) fn all_are_named(&self) -> bool {
        self.made.nameable().iter().all(|id| self.names(id))
    }

    /// Whether an effect is named.
    pub(super) fn names(&self, id: &str) -> bool {
        self.effects().iter().any(|named| named.is(id))
    }

    pub(super) fn closure(&self) -> Option<f64> {
        let (answer, floor) = (self.answer.as_ref()?, self.floor?);
        let room = answer.calibrated - floor;
        (room > 0.15 * floor).then(|| (answer.calibrated - answer.extended) / room)
    }
}

impl std::fmt::Display for Rate {
    /// The share and the numbers behind it; a dash where there are none.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.of {
            0 => formatter.write_str("–"),
            _ => write!(formatter, "{:.2} ({}/{})", self.share(), self.right, self.of),
        }
    }
}

/// How often something was right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(super) struct Rate {
    /// Times it was right.
    pub right: usize,
    /// Times it could have been.
    pub of: usize,
}

impl Rate {
    pub(super) fn count<'a>(
        outcomes: impl Iterator<Item = &'a Outcome>,
        right: impl Fn(&Outcome) -> bool,
    ) -> Self {
        outcomes.fold(Self::default(), |rate, outcome| rate.and(right(outcome)))
    }

    /// Counts one more.
    pub(super) fn and(self, right: bool) -> Self {
        Self { right: self.right + usize::from(right), of: self.of + 1 }
    }

    /// The share; `NaN` of nothing.
    pub(super) fn share(self) -> f64 {
        self.right as f64 / self.of as f64
    }
}
