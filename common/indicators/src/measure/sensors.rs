//! Sensors that deliver nonsense: missing, refused by the filter, frozen, or dead at zero.
//!
//! A value is *frozen* when it stays the same to the last bit while what it measures has changed by the witness of other
//! sensors. A wheel speed is *dead* when it drops to zero faster than a wheel can stop, or stays there while the wagon
//! rolls and nobody brakes. A sensor that is wrong by a little is not seen here.

use crate::measure::mean::FadingMean;
use bytemuck::{Pod, Zeroable};
use railgrip_messages::{Estimate, MAX_WHEELSETS, Sample, valid};

/// Speed, wheel speeds, pressing forces.
const CHANNELS: usize = 1 + 2 * MAX_WHEELSETS;
/// The witness must have changed by so much, m/s, and by this share.
const WITNESS_M_S: f64 = 0.5;
const WITNESS_SHARE: f64 = 0.03;
/// The witness of a pressing force must have changed by so much, N, and by this share.
const WITNESS_N: f64 = 5000.0;
const WITNESS_FORCE_SHARE: f64 = 0.3;
/// A rim slower than this is at zero, m/s.
const ZERO_M_S: f64 = 0.05;
/// A wagon faster than this rolls, m/s.
const ROLLS_M_S: f64 = 4.0;
/// A rim cannot lose more than this between two samples, m/s.
const JUMP_M_S: f64 = 3.0;
/// So long at zero without braking is dead, s.
const DEAD_S: f64 = 2.0;
/// A channel is named faulty from this share of bad values on.
const FAULTY_SHARE: f64 = 0.2;

/// One channel.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
struct Channel {
    last: f64,
    /// What the witness said when the value last changed.
    witness: f64,
    zero_s: f64,
    /// 1 while frozen or dead.
    dead: f64,
    bad: FadingMean,
    dead_share: FadingMean,
}

/// All channels of a wagon.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Sensors {
    channels: [Channel; CHANNELS],
}

/// A channel that is faulty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Faulty {
    /// Its bit in [`valid`].
    pub bit: u32,
    /// The wheelset, if it belongs to one.
    pub wheelset: Option<usize>,
    /// `speed`, `wheel speed` or `pressing force`.
    pub what: &'static str,
    /// Frozen or dead, not just missing or refused.
    pub dead: bool,
}

impl Sensors {
    /// Takes in a sample; gives the share of its values that are frozen or dead.
    pub fn add(
        &mut self,
        dt_s: f64,
        sample: &Sample,
        estimate: &Estimate,
        radius_m: f64,
        braking: bool,
        memory_s: f64,
    ) -> f64 {
        let count = sample.wheelset_count();
        let rims =
            (0..count).filter(|i| sample.has(valid::wheel_speed(*i)) && self.channels[1 + i].dead == 0.0);
        let (sum, number) =
            rims.fold((0.0, 0.0), |(sum, n), i| (sum + radius_m * sample.wheel_speed_rad_s[i], n + 1.0));
        let rim_m_s = if number > 0.0 { sum / number } else { f64::NAN };
        let speed_is_good = sample.has(valid::SPEED) && self.channels[0].dead == 0.0;
        let v_m_s = if speed_is_good { sample.v_m_s } else { f64::NAN };
        let speed = &mut self.channels[0];
        speed.frozen(sample.v_m_s, sample.has(valid::SPEED), rim_m_s, [WITNESS_M_S, WITNESS_SHARE]);
        let bad = !sample.has(valid::SPEED) || estimate.rejected & 1 != 0;
        speed.count(dt_s, bad, memory_s);
        for i in 0..count {
            let present = sample.has(valid::wheel_speed(i));
            let own_m_s = radius_m * sample.wheel_speed_rad_s[i];
            let witness = if v_m_s.is_finite() { v_m_s } else { estimate.v_m_s };
            let channel = &mut self.channels[1 + i];
            if present && own_m_s.abs() < ZERO_M_S {
                channel.at_zero(dt_s, witness, radius_m, braking);
                channel.last = sample.wheel_speed_rad_s[i];
            } else {
                channel.zero_s = 0.0;
                channel.frozen(sample.wheel_speed_rad_s[i], present, witness, [WITNESS_M_S, WITNESS_SHARE]);
            }
            channel.count(dt_s, !present || estimate.rejected & (2 << i) != 0, memory_s);
        }
        for i in 0..count {
            let present = sample.has(valid::pressing_force(i));
            let others = (0..count).filter(|j| *j != i && sample.has(valid::pressing_force(*j)));
            let (sum, number) =
                others.fold((0.0, 0.0), |(sum, n), j| (sum + sample.pressing_force_n[j], n + 1.0));
            let witness = if number > 0.0 { sum / number } else { f64::NAN };
            let vented = estimate.wsp_active != 0;
            let own_n = sample.pressing_force_n[i];
            let channel = &mut self.channels[1 + MAX_WHEELSETS + i];
            // Exactly zero is what a released or isolated brake may say; isolation is judged elsewhere.
            let witness = if own_n == 0.0 || vented { f64::NAN } else { witness };
            channel.frozen(own_n, present, witness, [WITNESS_N, WITNESS_FORCE_SHARE]);
            channel.count(dt_s, !present, memory_s);
        }
        let used = 1 + 2 * count;
        self.channels.iter().map(|channel| channel.dead).sum::<f64>() / used as f64
    }

    /// The channels that are faulty, the speed first.
    pub fn faulty(&self, wheelsets: usize) -> impl Iterator<Item = Faulty> + '_ {
        let at = move |index: usize| match index {
            0 => (valid::SPEED, None, "speed"),
            1..=MAX_WHEELSETS => (valid::wheel_speed(index - 1), Some(index - 1), "wheel speed"),
            _ => {
                let wheelset = index - 1 - MAX_WHEELSETS;
                (valid::pressing_force(wheelset), Some(wheelset), "pressing force")
            }
        };
        let faulty = move |(index, channel): (usize, &Channel)| {
            let dead = channel.dead_share.mean(0.5).is_some_and(|share| share > FAULTY_SHARE);
            let bad = channel.bad.mean(0.5).is_some_and(|share| share > FAULTY_SHARE);
            let (bit, wheelset, what) = at(index);
            let used = wheelset.is_none_or(|wheelset| wheelset < wheelsets);
            (used && (dead || bad)).then_some(Faulty { bit, wheelset, what, dead })
        };
        self.channels.iter().enumerate().filter_map(faulty)
    }
}

impl Channel {
    fn frozen(&mut self, value: f64, present: bool, witness: f64, [least, share]: [f64; 2]) {
        if !present {
            return;
        }
        if value != self.last {
            (self.last, self.witness, self.dead) = (value, witness, 0.0);
            return;
        }
        if !self.witness.is_finite() {
            self.witness = witness;
        }
        let needed = least.max(share * self.witness.abs());
        if (witness - self.witness).abs() > needed {
            self.dead = 1.0;
        }
    }

    /// A locked wheel gets to zero by braking, and not at once.
    fn at_zero(&mut self, dt_s: f64, v_m_s: f64, radius_m: f64, braking: bool) {
        let jumped = radius_m * self.last > JUMP_M_S && v_m_s > ROLLS_M_S;
        self.zero_s = if braking || v_m_s < ROLLS_M_S { 0.0 } else { self.zero_s + dt_s };
        if jumped || self.zero_s >= DEAD_S {
            self.dead = 1.0;
        }
    }

    fn count(&mut self, dt_s: f64, bad: bool, memory_s: f64) {
        self.bad.add(dt_s, f64::from(u8::from(bad)), memory_s);
        self.dead_share.add(dt_s, self.dead, memory_s);
    }
}
