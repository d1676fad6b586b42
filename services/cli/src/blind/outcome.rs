//! What became of one case, and how often things were right.

use serde::Serialize;

use super::{
    answer::{Answer, Named},
    make::Made,
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
    /// Effects that were named, strongest first.
    pub(super) fn effects(&self) -> &[Named] {
        self.answer.as_ref().map_or(&[], |answer| &answer.effects)
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
            _ if self.made.is_unknown() => self.says_unknown(),
            [] => self.answer.as_ref().is_some_and(|answer| answer.verdict == "none"),
            [id] => self.effects().first().is_some_and(|named| named.is(id)),
            _ => nameable.iter().all(|id| self.effects().iter().any(|named| named.is(id))),
        }
    }

    pub(super) fn closure(&self) -> Option<f64> {
        let (answer, floor) = (self.answer.as_ref()?, self.floor?);
        let room = answer.calibrated - floor;
        (room > 0.15 * floor).then(|| (answer.calibrated - answer.extended) / room)
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
