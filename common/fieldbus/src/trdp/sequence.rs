//! The sequence counter of one ComId of one sender.

/// A counter that goes back by more than this belongs to a sender that has begun again; less is an old telegram.
const BEGINS_AGAIN: u32 = 100;

/// What a telegram is after the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Followed {
    /// The next, after so many that never came.
    After {
        /// Telegrams that never came.
        lost: u32,
    },
    /// One that has been here before, or that others have overtaken.
    Old,
    /// The first of a sender, or the first after it began again.
    First,
}

/// Follows a counter.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sequence {
    last: Option<u32>,
}

impl Sequence {
    /// Takes the counter of the next telegram. It wraps around; an old telegram leaves it as it is.
    pub fn take(&mut self, counter: u32) -> Followed {
        let Some(last) = self.last.replace(counter) else { return Followed::First };
        let ahead = counter.wrapping_sub(last);
        let back = last.wrapping_sub(counter);
        // A sender that begins again begins at 0, whatever it had reached; a counter that leaps is no loss.
        if back < BEGINS_AGAIN && counter != 0 || back == 0 {
            self.last = Some(last);
            return Followed::Old;
        }
        if ahead > u32::MAX / 2 { Followed::First } else { Followed::After { lost: ahead - 1 } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_repeats_wraps_and_new_beginnings_are_told_apart() {
        let mut sequence = Sequence::default();
        let mut take = |counter| sequence.take(counter);
        assert_eq!(take(u32::MAX - 1), Followed::First);
        assert_eq!(take(u32::MAX), Followed::After { lost: 0 });
        assert_eq!(take(u32::MAX), Followed::Old);
        assert_eq!(take(2), Followed::After { lost: 2 });
        assert_eq!(take(1), Followed::Old);
        assert_eq!(take(3), Followed::After { lost: 0 });
        assert_eq!(take(5003), Followed::After { lost: 4999 });
        assert_eq!(take(17), Followed::First);
        assert_eq!(take(18), Followed::After { lost: 0 });
        assert_eq!(take(0), Followed::First);
        assert_eq!(take(0), Followed::Old);
    }
}
