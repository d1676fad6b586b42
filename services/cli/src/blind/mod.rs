//! `railgrip gap blind`: how well the diagnosis does on cases whose effect was withheld.
//!
//! Cases come from the truth plant, which shares no formula code with the models under test. Their labels are sealed
//! (SHA-256 over salt and labels, published before the first diagnosis), each case is diagnosed by a child process that
//! gets the case folder alone, and labels and salt are opened after the last.
//!
//! **Glossary.** *Withheld*: an effect with an id whose id was taken out of the library (`--without`), so that the right
//! answer is `unknown`. *Nameless*: an effect that no id names. *Twin*: the case without its effect, the same clutter;
//! the calibrated model's gap there is the *floor*. *Closure*: (calibrated − extended) / (calibrated − floor) on holdout.

mod answer;
mod args;
mod belief;
mod diagnose;
mod make;
mod outcome;
mod rankings;
mod score;
mod table;
mod verify;

use std::{fs, time::Instant};

pub use args::Args;

use crate::CliError;
use crate::sealed::{
    files::{cannot_write, write},
    parallel::{parallel, progress, threads},
    seal::{Sealed, salt_from},
};
use make::Made;
use outcome::Outcome;

/// Makes the cases, seals the labels, has every case diagnosed, opens the labels and prints the score.
pub fn run(args: &Args) -> Result<(), CliError> {
    if args.cases == 0 {
        return Err(CliError::bad_input("--cases 0: at least one case is needed"));
    }
    let threads = threads(args.threads);
    fs::create_dir_all(&args.out).map_err(|error| cannot_write(&args.out, &error))?;
    let orders = make::orders(args.cases, args.seed);
    let bar = progress("making cases", orders.len());
    let all = || true;
    let made = parallel(threads, orders.len(), all, |index| {
        let made = make::make(&args.out, &orders[index]);
        bar.inc(1);
        made
    });
    bar.finish_and_clear();
    let made = made.into_iter().collect::<Result<Vec<Made>, CliError>>()?;

    // The salt follows from the seed, so that an interrupted run continues under the same seal.
    let sealed = Sealed::new(salt_from(&format!("railgrip gap blind {}", args.seed)), &made)?;
    sealed.publish(&args.out)?;

    let surgery = diagnose::Surgery::new(args)?;
    let bar = progress("diagnosing", made.len());
    let started = Instant::now();
    let in_time = || args.minutes.is_none_or(|minutes| started.elapsed().as_secs_f64() < 60.0 * minutes);
    let outcomes = parallel(threads, made.len(), in_time, |index| {
        let outcome = surgery.outcome(&made[index]);
        bar.inc(1);
        outcome
    });
    bar.finish_and_clear();
    let outcomes: Vec<Outcome> = outcomes.into_iter().collect::<Result<_, CliError>>()?;

    // While cases are left, their labels stay sealed.
    if outcomes.len() == made.len() {
        sealed.open(&args.out)?;
    }
    let score = score::Score::of(&outcomes);
    let markdown = table::markdown(&score, &outcomes, args.cases, args.seed, sealed.digest());
    write(&args.out.join("score.md"), &markdown)?;
    write(
        &args.out.join("score.json"),
        &table::json(&score, &outcomes, args.cases, args.seed, sealed.digest())?,
    )?;
    crate::output::say(&markdown);
    Ok(())
}
