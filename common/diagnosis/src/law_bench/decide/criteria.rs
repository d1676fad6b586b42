//! Every threshold that decides about a law measured alone.
//!
//! Scores and ranks are in units of twice the log-likelihood: squared error over sigma², divided by what counts as one
//! independent degree of freedom ([`crate::law_bench::fit::noise::Noise::unit`]). *Set by hand* means: chosen on simulated
//! benches of the kind that `tests/law_simulated.rs` makes, not fitted; that test shows what they reach.

/// The thresholds. [`Criteria::default`] is what a diagnosis uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    // How noisy the bench is.
    /// Degrees of freedom that repeated points must offer before sigma is taken from them. Below that, an estimated sigma is
    /// off by more than a quarter. Set by hand.
    pub fewest_replicates: usize,
    /// Share of a variable's largest value within which two points count as repeated. Set by hand: finer than any set point
    /// can be held, coarser than rounding in a file.
    pub replicate_tolerance: f64,
    /// Correlation of neighbouring points, in standard errors, from which it is believed. Below, it is taken as zero. Set by
    /// hand: less than one case in a hundred shows more by chance.
    pub correlation_standard_errors: f64,
    /// Largest correlation of neighbours that is believed, so that evidence never shrinks to nothing. Set by hand.
    pub most_correlation: f64,
    /// Noise around the extended model over noise around the calibrated one, below which everything is judged again with
    /// the smaller noise. Set by hand: a difference of 15 % changes no verdict.
    pub judge_again_below: f64,
    /// Scatter over sigma from which the report says that points scatter more than declared. Set by hand.
    pub noted_scatter: f64,

    // Which points are left out to test predictions.
    /// Fewest files of which one is left out at a time; with fewer, blocks of rows are. Two files would leave one to fit on.
    pub fewest_files: usize,
    /// Folds where blocks of rows are left out. Set by hand, the usual number.
    pub blocks: usize,
    /// Share of a file's points outside the ranges of all others, from which leaving that file out would test extrapolation
    /// instead of prediction. Set by hand.
    pub most_outside: f64,
    /// Margin of those ranges, as a share of the variable's width. Set by hand.
    pub range_margin: f64,

    // What chance alone can do.
    /// Simulated sets of points behind each threshold of chance; 599 puts the 1 % level on the sixth largest.
    pub replicates: usize,
    /// Slow drift of friction that is a nuisance and no effect, one sigma, as a share of the level. From the definition of a
    /// case: about 0.6 %.
    pub drift_share: f64,
    /// Memory of that drift, as a share of a file's length. Set by hand.
    pub drift_memory: f64,

    // What is named.
    /// Probability of naming an effect where there is none. With [`Self::structure_level`] it makes up the 5 % of false alarms
    /// that a diagnosis may raise.
    pub library_level: f64,
    /// Most effects named at once. Set by hand: no more are told apart on a bench.
    pub most_effects: usize,
    /// Share of the first effect's score that a further one must reach, and of all that is explained that each must be worth.
    /// Below it a further effect mends the form of the first. Set by hand.
    pub material_share: f64,
    /// Score by which another form of a candidate must beat its preferred form. Set by hand: odds of twenty to one.
    pub form_margin: f64,
    /// Score that an effect must be worth to stay beside the others. Set by hand: odds of seven to one.
    pub least_worth: f64,

    // What is unknown.
    /// Probability of calling for an unknown effect where there is none.
    pub structure_level: f64,
    /// What must be left unexplained, in degrees of freedom a point, before it matters; 0.02 is 0.14 sigma RMS. Set by hand:
    /// smaller than what a sensor's calibration is good for.
    pub least_structure_per_point: f64,
    /// Share of the excess left from which a single variable without a named effect is weighed against the named effects.
    /// Set by hand.
    pub weigh_from: f64,
    /// Share of the excess that a right effect in a slightly wrong form leaves at most. Set by hand.
    pub most_left_by_form: f64,
    /// Share of the excess left above which the named effects cannot be the cause. Set by hand: they explain less than half.
    pub most_left_by_effects: f64,
    /// Score by which one variable without a named effect must beat all named effects together. Set by hand.
    pub simpler_margin: f64,
    /// The same as a share of the excess; the larger of the two counts. Set by hand.
    pub simpler_margin_share: f64,

    // How sure it is.
    /// Rank by which a rival may stand behind a named effect and still count as one that the data cannot tell apart. Set by
    /// hand: ranks of forms that are not exact scatter by about this much.
    pub tie: f64,
    /// Difference of rank that makes a rival e times less likely. An exact likelihood would need 2; 5 allows for forms that are
    /// not exact. Set by hand.
    pub evidence_unit: f64,
    /// Largest confidence of a named effect. Set by hand.
    pub surest: f64,
    /// Smallest confidence of a named effect. Set by hand.
    pub least_sure: f64,
}

impl Default for Criteria {
    fn default() -> Self {
        Self {
            fewest_replicates: 8,
            replicate_tolerance: 1e-4,
            correlation_standard_errors: 2.5,
            most_correlation: 0.9,
            judge_again_below: 0.85,
            noted_scatter: 1.15,
            fewest_files: 3,
            blocks: 5,
            most_outside: 0.4,
            range_margin: 0.05,
            replicates: 599,
            drift_share: 0.006,
            drift_memory: 0.3,
            library_level: 0.04,
            most_effects: 3,
            material_share: 0.005,
            form_margin: 6.0,
            least_worth: 4.0,
            structure_level: 0.01,
            least_structure_per_point: 0.02,
            weigh_from: 0.04,
            most_left_by_form: 0.12,
            most_left_by_effects: 0.5,
            simpler_margin: 10.0,
            simpler_margin_share: 0.02,
            tie: 9.0,
            evidence_unit: 5.0,
            surest: 0.98,
            least_sure: 0.02,
        }
    }
}
