//! The sim-to-real gap: where it lies, which unmodelled effect causes it, and how far it shrinks with the effect added.
//!
//! [`wagon::diagnose`] answers for recordings of a wagon and tells the story from end to end, [`law_bench::diagnose`] for a law
//! measured alone. The folders stand in the order in which the method works:
//!
//! * [`data`] – what was recorded, and what the simulator believes;
//! * [`model`] – what may be wrong: nuisances, the candidates of the library, flexible discrepancies;
//! * [`predict`] – whitened one-step errors, open-loop errors, and errors with one place of the equations freed;
//! * [`fit`] – the solver, what it minimises, whole models fitted by it;
//! * [`decide`] – which effects are selected, what chance alone would gain, the verdict and how sure it is;
//! * [`plan`] – the next run, which would tell apart what is left open, and what it says once it is made;
//! * [`answer`] – the form of a report; [`mod@write`] fills it, [`words`] says it in sentences, [`html`] draws it.
//!
//! Everything is deterministic: results are collected in the order of the library whatever the threads, random numbers
//! come from the seed, and sums run in a fixed order.
//!
//! # Glossary
//! * *nuisance* – a quantity of the nominal model that differs from case to case and is never the answer (pad levels, μ0 of
//!   each rail class, resistance, mass, inertia); fitted first, and again with every candidate.
//! * *candidate* – an effect of the catalogue, with the starts from which its parameters are fitted.
//! * *disturbance model* – what varies along a run without being an effect: pad friction that drifts, gusts, noise.
//! * *innovation* – measured minus predicted output, one sample ahead; *whitened*: divided by the root of its covariance, so
//!   that a right model leaves white noise of variance one.
//! * *frozen fit* – a model fitted with the filter's gains held as they were computed at that model. Its *tolerance* says how
//!   much error of the model the filter allows for: 0 none, 3 so much that it hardly looks beyond one step.
//! * *path* – where a frozen filter stood at each sample; the *response* is what another model changes of its innovations,
//!   worked out along the path instead of by simulating again.
//! * *gain* – decrease of minus the log-likelihood; *predictive*: on runs left out. *Evidence* – the same between filters
//!   frozen at different models or tolerances, so that the determinants of their covariances count as well.
//! * *place* – a term of the equations or a sensor where a disturbance can act; *freeing* it adds a random disturbance there
//!   as one more state. *Localising* frees every place in turn: where the recordings become most likely, the model errs.
//! * *flexible discrepancy* – a curve over one covariate at one place: what could be explained at all, by a law that nobody
//!   has named. *Beside* the effects it shows what they leave, *instead* of them whether they are the answer.
//! * *mending* – a further effect at the place of one before it that only takes up what the other's form leaves.
//! * *rival*, *tie* – another candidate that does nearly as well as a named one; so nearly that the recordings cannot tell them
//!   apart. Effects that look alike by their nature are *twins* in the effect's spec.
//! * *rule* – a line of the table of verdicts; the first that holds decides. All limits are [`decide::criteria`].
//! * *gap*, *nominal*, *calibrated*, *extended* – see [`answer::schema`].

pub mod answer;
pub mod data;
pub mod decide;
pub mod fit;
pub mod html;
pub mod law_bench;
pub mod model;
pub mod plan;
pub mod predict;
mod shown;
pub mod wagon;
pub mod words;
pub mod write;
