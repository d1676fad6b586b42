//! How long a filter may go on without a measured speed, live and on recordings.

/// For so long a filter goes on without a measured speed, s; then it would tell what nobody has measured.
const GOES_ON_S: f64 = 2.0;

/// Since when no speed has been measured.
#[derive(Debug, Default)]
pub struct Sight {
    /// Time of the sample that had one last, s.
    seen_s: Option<f64>,
}

impl Sight {
    /// Takes the time of a sample, s, and whether it has a speed of the vehicle or of a wheelset; says whether the filter goes on.
    pub fn goes_on(&mut self, time_s: f64, measured: bool) -> bool {
        let seen_s = self.seen_s.get_or_insert(time_s);
        // A source that began anew counts from its own beginning.
        if measured || time_s < *seen_s {
            *seen_s = time_s;
        }
        time_s - *seen_s <= GOES_ON_S
    }
}
