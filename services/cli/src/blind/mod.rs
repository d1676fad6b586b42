//! `railgrip gap blind`: how well the diagnosis does on cases whose effect was withheld.
//!
//! Cases come from the truth plant, which shares no formula code with the models under test. Their labels are sealed
//! (SHA-256 over salt and labels, published before the first diagnosis), each case is diagnosed by a child process that
//! gets the case folder alone and no seed of the cases, and labels and salt are opened after the last. The cases follow from
//! seed and salt together, and the salt is random.
//!
//! **Glossary.** *Withheld*: an effect with an id whose id was taken out of the library (`--without`), so that the right
//! answer is `unknown`. *Nameless*: an effect that no id names. *Twin*: the case without its effect, the same clutter;
//! the calibrated model's gap there is the *floor*. *Salience*: the calibrated gap over that floor as the plant measures
//! both. *Closure*: (calibrated − extended) / (calibrated − floor) on holdout.

mod answer;
mod args;
mod belief;
mod diagnose;
mod make;
mod meaning;
mod next_run;
mod outcome;
mod rankings;
mod salt;
mod score;
mod slices;
mod table;
mod verify;

use std::{fs, time::Instant};

pub use args::Args;

use crate::CliError;
use crate::sealed::{
    files::{cannot_write, write},
    parallel::{parallel, progress, threads},
    seal::Sealed,
};
pub(crate) use make::{Made, VISIBLE};
use outcome::Outcome;

/// Most cases of one run.
const MOST_CASES: usize = 1_000_000;

/// Makes the cases, seals the labels, has every case diagnosed, opens the labels and prints the score.
pub fn run(args: &Args) -> Result<(), CliError> {
    if args.cases > MOST_CASES {
        let said = format!("--cases {}: allowed is 1 to {MOST_CASES}", args.cases);
        return Err(CliError::bad_input(said));
    }
    if args.cases == 0 {
        return Err(CliError::bad_input("--cases 0: at least one case is needed"));
    }
    let threads = threads(args.threads);
    fs::create_dir_all(&args.out).map_err(|error| cannot_write(&args.out, &error))?;
    if let Some(file) = &args.open_labels {
        let made = make_all(args, threads, args.seed)?;
        write(file, &serde_json::to_string_pretty(&made).map_err(CliError::failed)?)?;
        return say_where(args, &made);
    }
    let salt = salt::of(&args.out, args.salt.as_deref())?;
    let made = make_all(args, threads, salt::seed(&salt, args.seed))?;
    let sealed = Sealed::new(salt, &made)?;
    sealed.publish(&args.out)?;
    if args.make_only {
        return say_where(args, &made);
    }

    let surgery = diagnose::Surgery::new(args)?;
    let bar = progress("diagnosing", made.len());
    let started = Instant::now();
    let in_time = || args.minutes.is_none_or(|minutes| started.elapsed().as_secs_f64() < 60.0 * minutes);
    let outcomes = parallel(threads, made.len(), in_time, |index| {
        let outcome = surgery.outcome(&made[index]);
        bar.inc();
        outcome
    });
    bar.finish();
    let outcomes: Vec<Outcome> = outcomes.into_iter().collect::<Result<_, CliError>>()?;

    let in_doubt: Vec<&Outcome> = outcomes.iter().filter(|outcome| next_run::is_in_doubt(outcome)).collect();
    let in_doubt = &in_doubt[..args.next_runs.min(in_doubt.len())];
    let orders = make::orders(args.cases, salt::seed(sealed.salt(), args.seed), args.forms.forms());
    let bar = progress("next runs", in_doubt.len());
    let next = parallel(threads, in_doubt.len(), in_time, |index| {
        let outcome = in_doubt[index];
        let order = orders.iter().find(|order| order.recipe.name == outcome.made.label.case);
        let next = order.map_or(Ok(None), |order| next_run::of(&surgery, outcome, order));
        bar.inc();
        next
    });
    bar.finish();
    let next: Vec<Option<next_run::Next>> = next.into_iter().collect::<Result<_, CliError>>()?;
    let next: Vec<next_run::Next> = next.into_iter().flatten().collect();

    // While cases are left, their labels stay sealed.
    if outcomes.len() == made.len() {
        sealed.open(&args.out)?;
    }
    let score = score::Score::of(&outcomes);
    let head =
        table::Head { cases: args.cases, seed: args.seed, forms: args.forms.word(), digest: sealed.digest() };
    let markdown = table::markdown(&score, &outcomes, &head) + &next_run::markdown(&next);
    write(&args.out.join("score.md"), &markdown)?;
    write(&args.out.join("score.json"), &table::json(&score, &outcomes, &next, &head)?)?;
    crate::output::say(&markdown);
    Ok(())
}

/// Makes all cases on disk. Twins are written only if the diagnosis is to measure the floor on them.
fn make_all(args: &Args, threads: usize, seed: u64) -> Result<Vec<Made>, CliError> {
    let orders = make::orders(args.cases, seed, args.forms.forms());
    let bar = progress("making cases", orders.len());
    let with_twin = args.floor == args::Floor::Diagnosis && !args.make_only;
    let made = parallel(
        threads,
        orders.len(),
        || true,
        |index| {
            let made = make::make(&args.out, &orders[index], with_twin);
            bar.inc();
            made
        },
    );
    bar.finish();
    let made = made.into_iter().collect::<Result<Vec<Made>, CliError>>()?;
    if made.len() != orders.len() {
        return Err(CliError::failed("a thread that made cases ended early"));
    }
    Ok(made)
}

fn say_where(args: &Args, made: &[Made]) -> Result<(), CliError> {
    crate::output::say(&format!("{} cases in {}", made.len(), args.out.join("cases").display()));
    Ok(())
}
