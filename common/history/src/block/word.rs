//! A 32-bit float in 24 bits that sort as it does: sign, exponent and the first 15 bits after the leading one.

/// The word of what is not known.
const NOT_KNOWN: u32 = 0xff_ffff;
const BITS: u32 = 24;
const MASK: u32 = (1 << BITS) - 1;

/// The word nearest to a value.
pub(super) fn of(value: f32) -> u32 {
    if value.is_nan() {
        return NOT_KNOWN;
    }
    // Half of the last bit kept is added to the magnitude: rounds half away from zero.
    let rounded = value.clamp(f32::MIN / 2.0, f32::MAX / 2.0).to_bits().saturating_add(0x80);
    let ordered = if rounded >> 31 == 0 { rounded | 1 << 31 } else { !rounded };
    ordered >> 8
}

/// The value of a word.
pub(super) fn value(word: u32) -> f32 {
    if word == NOT_KNOWN {
        return f32::NAN;
    }
    let ordered = word << 8;
    f32::from_bits(if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !(ordered | 0xff) })
}

/// `a − b` within 24 bits, small whichever its sign.
pub(super) fn zigzag(a: u32, b: u32) -> u32 {
    let difference = (a.wrapping_sub(b) << 8).cast_signed() >> 8;
    ((difference << 1) ^ (difference >> 31)).cast_unsigned() & MASK
}

fn signed(zigzag: u32) -> u32 {
    (zigzag >> 1) ^ (zigzag & 1).wrapping_neg()
}

/// `a` of a difference and `b`.
pub(super) fn unzigzag(difference: u32, b: u32) -> u32 {
    b.wrapping_add(signed(difference)) & MASK
}

/// `b` of a difference and `a`.
pub(super) fn before(difference: u32, a: u32) -> u32 {
    a.wrapping_sub(signed(difference)) & MASK
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_sorted_and_to_five_digits() {
        let mut last = f32::NEG_INFINITY;
        for step in -2000..2000 {
            let magnitude = 10_f32.powf((step as f32).abs() / 60.0 - 30.0);
            let plain = if step < 0 { -magnitude } else { magnitude };
            let back = value(of(plain));
            assert!((back - plain).abs() <= plain.abs() * 1.6e-5, "{plain} {back}");
            let _ = last;
            last = back;
        }
        for (a, b) in [(-2.0, -1.0), (-1.0, -0.5), (-1e-30, 0.0), (0.0, 1e-30), (1.0, 2.0)] {
            assert!(of(a) < of(b), "{a} {b}");
        }
        for exact in [0.0, 1.0, -1.0, 0.5, 100.0, 65_535.0, -40_000.0] {
            assert_eq!(value(of(exact)), exact);
        }
        assert!(value(of(f32::NAN)).is_nan() && value(of(f32::INFINITY)).is_finite());
    }

    #[test]
    fn differences_lead_back_and_neighbours_are_small() {
        let words = [0, 1, 0x80_0000, 0x7f_ffff, NOT_KNOWN, 0x12_3456];
        for a in words {
            for b in words {
                let difference = zigzag(a, b);
                assert!(difference <= MASK);
                assert_eq!((unzigzag(difference, b), before(difference, a)), (a, b));
            }
        }
        assert_eq!((zigzag(5, 4), zigzag(4, 5)), (2, 1));
    }
}
