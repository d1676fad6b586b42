//! What sensors and recorders add: white and coloured noise, resolution, outliers and dropouts.

use crate::random::Stream;

/// How a case's recordings are disturbed. The data sheet knows the white sigma alone.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Noise {
    /// Level over that of the data sheet, 1 to 1.5.
    pub level: f64,
    /// Share of the variance that is coloured, 0 to 0.8.
    pub coloured_share: f64,
    /// Correlation time of the coloured part, s.
    pub correlation_s: f64,
    /// Resolution of speed and wheel speeds over their sigmas; 0 for that of the file.
    pub resolution: f64,
    /// Probability of an outlier in a reading.
    pub outliers: f64,
    /// Dropouts a minute.
    pub dropouts_per_min: f64,
}

impl Noise {
    /// White noise of the sheet's own level.
    pub const WHITE: Self = Self {
        level: 1.0,
        coloured_share: 0.0,
        correlation_s: 0.1,
        resolution: 0.0,
        outliers: 0.0,
        dropouts_per_min: 0.0,
    };

    /// Draws the kinds of noise of a case; every second case has white noise alone at most 1.5 times too strong.
    #[must_use]
    pub fn draw(stream: &mut Stream) -> Self {
        let level = if stream.chance(0.4) { 1.0 } else { stream.uniform(1.0, 1.5) };
        let mut noise = Self { level, ..Self::WHITE };
        if stream.chance(0.4) {
            return noise;
        }
        if stream.chance(0.5) {
            noise.coloured_share = stream.uniform(0.2, 0.8);
            noise.correlation_s = stream.uniform(0.05, 0.3);
        }
        if stream.chance(0.3) {
            noise.resolution = stream.uniform(0.5, 2.5);
        }
        if stream.chance(0.25) {
            noise.outliers = stream.uniform(-8.5, -6.0).exp();
        }
        if stream.chance(0.25) {
            noise.dropouts_per_min = stream.uniform(0.5, 4.0);
        }
        noise
    }

    /// The kinds in words, for labels and scores.
    #[must_use]
    pub fn kinds(&self) -> Vec<&'static str> {
        let kinds = [
            (self.coloured_share > 0.0, "coloured"),
            (self.resolution > 0.0, "quantised"),
            (self.outliers > 0.0, "outliers"),
            (self.dropouts_per_min > 0.0, "dropouts"),
        ];
        let present: Vec<&str> = kinds.into_iter().filter(|(is, _)| *is).map(|(_, kind)| kind).collect();
        if present.is_empty() { vec!["white"] } else { present }
    }
}

/// One disturbed channel of one run.
#[derive(Debug, Clone)]
pub struct Channel {
    stream: Stream,
    white: f64,
    coloured: f64,
    keep: f64,
    kick: f64,
    resolution: f64,
    sigma: f64,
    outliers: f64,
    dropout_probability: f64,
    sample_s: f64,
    silent: usize,
    /// Smallest digit of the file.
    digit: f64,
}

impl Channel {
    /// A channel whose sheet states `sigma`; `stream` is its own.
    #[must_use]
    pub fn new(noise: &Noise, mut stream: Stream, sigma: f64, sample_s: f64, digit: f64) -> Self {
        let (white, coloured) = ((1.0 - noise.coloured_share).sqrt(), noise.coloured_share.sqrt());
        let keep = (-sample_s / noise.correlation_s).exp();
        let scale = noise.level * sigma;
        Self {
            coloured: coloured * scale * stream.normal(),
            stream,
            white: white * scale,
            keep,
            kick: coloured * scale * (1.0 - keep * keep).sqrt(),
            resolution: (noise.resolution * sigma).max(digit),
            sigma,
            outliers: noise.outliers,
            dropout_probability: noise.dropouts_per_min / 60.0 * sample_s,
            sample_s,
            silent: 0,
            digit,
        }
    }

    /// What is recorded of a true value; `NaN` in a dropout.
    pub fn read(&mut self, value: f64) -> f64 {
        self.coloured = self.keep * self.coloured + self.kick * self.stream.normal();
        let mut shown = value + self.coloured + self.white * self.stream.normal();
        if self.outliers > 0.0 && self.stream.chance(self.outliers) {
            shown += self.stream.sign() * self.sigma * self.stream.uniform(6.0, 30.0);
        }
        if self.dropout_probability > 0.0 {
            if self.silent == 0 && self.stream.chance(self.dropout_probability) {
                // Mostly too short to part windows, now and then long enough.
                let longest_s = if self.stream.chance(0.15) { 1.5 } else { 0.4 };
                self.silent = (self.stream.uniform(0.02, longest_s) / self.sample_s).ceil() as usize;
            }
            if self.silent > 0 {
                self.silent -= 1;
                return f64::NAN;
            }
        }
        let stepped = (shown / self.resolution).round() * self.resolution;
        (stepped / self.digit).round() * self.digit
    }
}
