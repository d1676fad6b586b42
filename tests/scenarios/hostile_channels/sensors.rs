//! What sound sensors send.

use crate::nonsense::{BOGIE, DRIVEN};
use railgrip_bus::{Bus, BusError, Publisher, now};
use railgrip_messages::{BogieSample, MotorSample, Sample, valid};
use std::time::{Duration, Instant};

pub fn sample(k: u64) -> Sample {
    let mut sample =
        Sample { sequence: k, acquired: now(), time_s: k as f64 * 0.01, wheelsets: 2, ..Sample::default() };
    sample.v_m_s = 20.0;
    sample.wheel_speed_rad_s[..2].fill(20.0 / 0.44);
    sample.valid = valid::SPEED
        | valid::wheel_speed(0)
        | valid::wheel_speed(1)
        | valid::pressing_force(0)
        | valid::pressing_force(1);
    sample
}

/// A hundredth of a second of everything that sensors send.
pub struct Sensors {
    wagons: Vec<Publisher<Sample>>,
    rigs: Option<(Publisher<MotorSample>, Publisher<BogieSample>)>,
    k: u64,
}

impl Sensors {
    /// Of so many wagons, and of both rigs or none.
    pub fn open(bus: &Bus, wagons: u32, rigs: bool) -> Result<Self, BusError> {
        let wagons = (1..=wagons).map(|wagon| bus.sample_publisher(wagon)).collect::<Result<_, _>>()?;
        let both = || Ok::<_, BusError>((bus.motor_publisher(DRIVEN)?, bus.bogie_publisher(BOGIE)?));
        Ok(Self { wagons, rigs: rigs.then(both).transpose()?, k: 0 })
    }

    pub fn run(&mut self, seconds: f64) {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while Instant::now() < until {
            self.k += 1;
            let (sequence, time_s, acquired) = (self.k, self.k as f64 * 0.01, now());
            self.wagons.iter().for_each(|wagon| wagon.publish(&[sample(sequence)]).expect("published"));
            if let Some((motors, bogies)) = &self.rigs {
                motors
                    .publish(&[MotorSample { sequence, time_s, acquired, ..MotorSample::default() }])
                    .expect("published");
                bogies
                    .publish(&[BogieSample { sequence, time_s, acquired, ..BogieSample::default() }])
                    .expect("published");
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}
