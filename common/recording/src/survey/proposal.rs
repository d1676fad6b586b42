//! The proposal in the words of a config.

use super::Surveyed;
use super::units::unit_of_run;
use crate::columns::Quantity;

/// The proposal as the table `[mapping]` of a config, with the figures of each column beside it and every doubt above it.
#[must_use]
pub fn proposal(surveyed: &[Surveyed]) -> String {
    let mut lines = vec!["[mapping]".to_owned()];
    for column in surveyed {
        let figures = match column.figures {
            Some((count, least, most)) if count > 0 => format!("{count} numbers, {least} to {most}"),
            Some(_) => "empty".to_owned(),
            None => "no numbers".to_owned(),
        };
        let from = column.name.replace('\\', "\\\\").replace('"', "\\\"");
        let Some(guess) = &column.guess else {
            lines.push(format!("# \"{from}\": not used; {figures}"));
            continue;
        };
        if let Some(doubt) = &guess.doubt {
            lines.push(format!("# doubt: {}, {doubt}", guess.to));
        }
        if guess.to == column.name && guess.unit.is_none() {
            lines.push(format!("# {}: has its name already, in {}; {figures}", guess.to, unit_of_run(guess)));
            continue;
        }
        let unit = guess.unit.map_or_else(String::new, |unit| format!(", unit = \"{unit}\""));
        let scale = guess.scale.map_or_else(String::new, |scale| format!(", scale = {scale:?}"));
        lines.push(format!("{} = {{ from = \"{from}\"{unit}{scale} }}    # {figures}", guess.to));
    }
    let has = |quantity: Quantity| {
        let of = |to: &str| (1..=4).any(|wheelsets| quantity.column(0, wheelsets) == to);
        surveyed.iter().filter_map(|column| column.guess.as_ref()).any(|guess| of(&guess.to))
    };
    for quantity in Quantity::ALL.into_iter().filter(|quantity| quantity.required() && !has(*quantity)) {
        lines.push(format!("# missing: {} ({})", quantity.column(0, 2), quantity.unit()));
    }
    lines.join("\n")
}
