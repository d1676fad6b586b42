//! Alerts that people do not learn to ignore. The words are Alertmanager's.
//!
//! An alert's way: rule → group → inhibit → silence → notify.
//!
//! | step | file | what happens |
//! | --- | --- | --- |
//! | rule | `rule` (from the table of indicators), `evaluate` | a *symptom* is a rule broken at one place; it fires when it has lasted, and stops when it has stayed away: twice as long each time it comes back |
//! | group | `group` | symptoms of one *cause* make one alert: pad friction and asymmetry of a wagon, all its wheelsets; a cause that most wagons share (a low rail) makes one alert of the train that lists them |
//! | inhibit | `rule`, `group` | what a worse symptom explains raises nothing of its own: a dead sensor explains a filter that disagrees |
//! | silence | `operator` | people acknowledge an alert, or silence it for a time; what becomes worse comes back by itself |
//! | notify | [`notify`] | receivers are told of what was raised, became worse, came back or is over |
//!
//! Each alert has a reason and advice in words, a link to its evidence, and a history of what happened to it. All of it
//! survives a restart ([`journal`]), and so does what is yet to be sent ([`nflog`], the notification log).

mod book;
mod change;
pub mod diagnosis;
mod evaluate;
mod group;
pub mod journal;
mod judged;
pub mod model;
pub mod moved;
pub mod nflog;
pub mod notify;
mod operator;
mod place;
mod recordings;
pub mod routes;
mod rule;
mod shared;
#[cfg(test)]
mod tests;
mod vehicles;

pub use book::AlertBook;
pub use evaluate::Symptom;
pub use operator::Refusal;
pub use shared::SharedBook;
pub use vehicles::Vehicles;
