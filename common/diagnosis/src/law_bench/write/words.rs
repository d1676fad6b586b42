//! What the report of a law-level case says in sentences.

use super::findings::Findings;
use crate::answer::supplement::Tie;
use crate::law_bench::data::case::{Kind, Nominal};
use crate::law_bench::decide::confidence::tied;
use crate::law_bench::decide::criteria::Criteria;
use crate::law_bench::decide::selection::SelectedEffect;
use crate::law_bench::fit::left_out::Scheme;
use crate::words::format::number;

/// The named effects that have rivals, with the reason.
pub fn ties(effects: &[SelectedEffect], criteria: &Criteria) -> Vec<Tie> {
    let with_rivals = effects.iter().map(|effect| (effect, tied(effect, criteria)));
    with_rivals
        .filter(|(_, rivals)| !rivals.is_empty())
        .map(|(effect, rivals)| {
            let ids = std::iter::once(effect.spec.id).chain(rivals.iter().map(|rival| rival.id));
            let meanings: Vec<&str> = rivals.iter().map(|rival| rival.meaning).collect();
            let because = format!(
                "On these points \"{}\" and \"{}\" change the prediction in the same way.",
                effect.spec.meaning,
                meanings.join("\" and \"")
            );
            Tie { ids: ids.map(str::to_owned).collect(), because }
        })
        .collect()
}

/// The measurement that would separate what ties, or show what is missing.
pub fn next_run(findings: &Findings) -> Option<String> {
    if !findings.names_effects() {
        let discrepancy = findings.missing.as_ref()?;
        let variable = discrepancy.covariate.name().replace('_', " ");
        return Some(match discrepancy.second {
            Some(second) => format!(
                "Measure a grid of {variable} and {} with all else held constant: what is missing is how they act together.",
                second.name().replace('_', " ")
            ),
            None => format!(
                "Vary {variable} alone over its whole range, up and down, with all else held constant. That shows the missing law, and whether it depends on what happened before."
            ),
        });
    }
    let mut effects = findings.selection.effects.iter();
    let (effect, rival) =
        effects.find_map(|effect| Some((effect, *tied(effect, &findings.criteria).first()?)))?;
    let (spec, isolate) = (effect.spec, rival.isolate);
    Some(format!("To tell {} from {}: {}; and {isolate}.", spec.id, rival.id, spec.isolate))
}

/// The bench in a line.
pub fn subject(findings: &Findings) -> String {
    let law = match findings.case.nominal {
        Nominal::Creep { mu0, stiffness_n, k_a, k_s } => {
            format!(
                "creep bench; nominal law: Polach with mu0 {mu0}, K {stiffness_n} N, k_A {k_a}, k_S {k_s}"
            )
        }
        Nominal::Brake { friction_coefficient } => {
            format!("brake bench; nominal law: constant friction {friction_coefficient}")
        }
    };
    let case = &findings.case;
    format!("{law}; {} points to fit on, {} to predict", case.fit.points.len(), case.holdout.points.len())
}

/// What a reader must know about noise and left-out data.
pub fn notes(findings: &Findings) -> Vec<String> {
    let noise = &findings.noise;
    let unit = if findings.case.kind == Kind::Creep { " N" } else { "" };
    let sigma = number(noise.sigma);
    let mut notes = vec![format!("Sigma {sigma}{unit} is {}.", findings.sigma_source)];
    if noise.excess > findings.criteria.noted_scatter {
        notes.push(format!(
            "The points scatter by {:.2} sigma about a smooth curve through them, so all evidence is judged by that larger scatter.",
            noise.excess
        ));
    }
    if noise.correlation > 0.0 {
        notes.push(format!(
            "Neighbouring points resemble each other (correlation {:.2}); evidence and intervals allow for that.",
            noise.correlation
        ));
    }
    notes.push(match findings.scheme {
        Scheme::Files => "To test predictions, one file at a time was left out of the fit.".to_owned(),
        Scheme::Blocks => {
            "To test predictions, blocks of neighbouring rows were left out of the fit. Whole files would have tested extrapolation."
                .to_owned()
        }
    });
    notes
}
