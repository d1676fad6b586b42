//! A running train reads its config again, on SIGHUP.
//!
//! The file is checked as completely as at a start; one that is wrong, or that changes what cannot change while the train runs,
//! changes nothing at all. What is left is taken over by running processes where they can, and the others that it touches start
//! again: [`table`] says who does which. Under `railgrip up` the supervisor reads the file and drives the processes one after
//! another; under systemd each is sent SIGHUP by its unit and follows by itself.
//!
//! | file | its job |
//! | --- | --- |
//! | `table` | every setting: whom it touches, and how |
//! | `plan` | what lies between two configs |
//! | `role` | the processes of a train |
//! | `hangup` | the signal |

mod hangup;
mod plan;
mod role;
mod table;

use railgrip_bus::{BusConfig, Lifecycle, Turn, take_turn};
use railgrip_settings::TrainSettings;

pub(crate) use hangup::Hangup;
pub(crate) use plan::Plan;
pub(crate) use role::Role;
pub(crate) use table::{Way, explained};

use crate::train::{Train, TrainArgs};
use crate::{CliError, check, logging, supervisor};

/// A config that was read again and can be followed.
pub(crate) struct Again {
    pub settings: TrainSettings,
    pub text: String,
    pub plan: Plan,
}

/// Reads the config again.
///
/// # Errors
/// All that is wrong with it, in words, file and key named.
pub(crate) fn read_again(args: &TrainArgs, running: &TrainSettings) -> Result<Again, Vec<String>> {
    let one = |error: CliError| vec![error.to_string()];
    let (file, text) = args.text().map_err(one)?;
    let settings = check::completely(&file, &text, &args.overrides())?;
    BusConfig::of(&settings).validate().map_err(|error| one(error.into()))?;
    let plan = Plan::of(running, &settings);
    let fixed = |key: &str| {
        format!(
            "{}: `{key}` cannot change while the train runs; stop the train and start it again, or take the change back",
            file.display()
        )
    };
    let refused: Vec<String> = plan.refused().into_iter().map(fixed).collect();
    if refused.is_empty() { Ok(Again { settings, text, plan }) } else { Err(refused) }
}

/// Says why a config is not followed.
pub(crate) fn refuse(problems: &[String]) {
    tracing::error!(mistakes = problems.len(), "the config is refused, and nothing changes");
    for problem in problems {
        tracing::error!("{problem}");
    }
}

/// One process of a train, as far as its config goes.
#[derive(Clone, Copy)]
pub(crate) struct Member<'a> {
    args: &'a TrainArgs,
    settings: &'a TrainSettings,
    role: Role,
}

impl<'a> Member<'a> {
    /// A process of the train that these arguments led to.
    pub(crate) fn of(args: &'a TrainArgs, train: &'a Train, role: Role) -> Self {
        Self { args, settings: &train.settings, role }
    }
}

/// Follows the config of one process.
pub(crate) struct Follower<'a> {
    member: Member<'a>,
    hangup: Hangup,
    /// What it goes by now, once that is not what it started with.
    settings: Option<Box<TrainSettings>>,
    /// It shall end in order to start again, when its turn comes.
    leaves: bool,
    turn: Option<Turn>,
}

impl<'a> Follower<'a> {
    /// Listens for SIGHUP from now on.
    pub(crate) fn new(member: Member<'a>) -> Result<Self, CliError> {
        Ok(Self { member, hangup: Hangup::listen()?, settings: None, leaves: false, turn: None })
    }

    /// Reads the config again if it was asked to.
    pub(crate) fn look(&mut self, lifecycle: &Lifecycle) {
        if self.hangup.asked(lifecycle) {
            self.read_again(lifecycle);
        }
        if self.leaves {
            self.leave(lifecycle);
        }
    }

    /// Ends in order to start again, unless another that does so is not back yet.
    fn leave(&mut self, lifecycle: &Lifecycle) {
        let bus = BusConfig::of(self.member.settings);
        let turn = self.member.role.process().map(|(process, wagon)| take_turn(&bus, process, wagon));
        match turn.transpose() {
            Ok(Some(None)) => return,
            Ok(turn) => self.turn = turn.flatten(),
            Err(error) => tracing::warn!(%error, "whose turn it is cannot be told"),
        }
        self.leaves = false;
        lifecycle.stop();
    }

    fn read_again(&mut self, lifecycle: &Lifecycle) {
        let running = self.settings.as_deref().unwrap_or(self.member.settings);
        let Again { settings, plan, .. } = match read_again(self.member.args, running) {
            Ok(again) => again,
            Err(problems) => return refuse(&problems),
        };
        let changed = plan.keys().join(", ");
        logging::set_level(&settings.logging.level);
        match plan.way(self.member.role) {
            None => {
                tracing::info!(changed, "the config was read again and says nothing new for this process")
            }
            Some(Way::Live) => {
                tracing::info!(changed, "the config was read again and is taken over");
                lifecycle.offer(settings.clone());
            }
            // Its supervisor has read the same.
            Some(Way::Restart) if supervisor::is_of_up() => {}
            Some(Way::Restart) if supervisor::is_supervised() => {
                tracing::info!(
                    changed,
                    "the config was read again; this process ends in its turn, to be started again by it"
                );
                self.leaves = true;
            }
            Some(Way::Restart) => {
                tracing::warn!(
                    changed,
                    "the config has changed in what this process only takes at its start"
                );
                return;
            }
        }
        self.settings = Some(Box::new(settings));
    }
}
