//! The alerts of the watch as the channel carries them.

use railgrip_bus::now;
use railgrip_causes::{Alert, Cause, TrainWatch};
use railgrip_messages::{Grade, MAX_RUNNERS, MAX_VERDICTS, Text, Verdict, Verdicts};

/// What stands now. A silent wagon is not told: the age of its data shows that sooner, and to every reader.
pub(crate) fn verdicts(watch: &TrainWatch, wagons: usize) -> Verdicts {
    let mut all = Verdicts {
        stamp: now(),
        time_s: watch.time_s(),
        brakings: watch.brakings(),
        wagons: wagons as u32,
        ..Verdicts::default()
    };
    let standing = watch.alerts().iter().enumerate();
    let standing = standing.filter(|(_, alert)| alert.cleared_t_s.is_none() && alert.cause != Cause::Silent);
    for (place, (index, alert)) in all.verdict.iter_mut().zip(standing.take(MAX_VERDICTS)) {
        *place = verdict(index as u32 + 1, alert);
        all.count += 1;
    }
    all
}

fn verdict(number: u32, alert: &Alert) -> Verdict {
    let grade = match alert.grade {
        railgrip_causes::Grade::Watch => Grade::Watch,
        railgrip_causes::Grade::Act => Grade::Act,
    };
    let mut verdict = Verdict {
        probability: alert.probability,
        cause: alert.cause.code(),
        grade: grade.code(),
        wheelsets: alert.wheelsets.iter().fold(0, |bits, k| bits | 1 << k),
        brakings_seen: alert.brakings_seen,
        number,
        found_t_s: alert.raised_t_s,
        reason: Text::new(&alert.reason),
        ..Verdict::default()
    };
    alert.wagons.iter().for_each(|wagon| verdict.add_wagon(*wagon as u32 + 1));
    for (place, runner) in alert.instead.iter().take(MAX_RUNNERS).enumerate() {
        verdict.instead[place] = runner.cause.code();
        verdict.instead_probability[place] = runner.probability;
    }
    verdict
}
