//! The proposal in the words of a config.

use super::Surveyed;
use super::units::unit_of_run;
use crate::columns::Quantity;

/// The proposal as the table `[mapping]` of a config, with the figures of each column beside it and every doubt above it;
/// `reword` says a sentence of the table of messages in the language of whoever reads.
#[must_use]
pub fn proposal(surveyed: &[Surveyed], reword: impl Fn(&str) -> String) -> String {
    let mut lines = vec!["[mapping]".to_owned()];
    let remark = |lines: &mut Vec<String>, sentence: &str| lines.push(format!("# {}", reword(sentence)));
    for column in surveyed {
        let figures = figures(column);
        let from = column.name.replace('\\', "\\\\").replace('"', "\\\"");
        let Some(guess) = &column.guess else {
            remark(&mut lines, &format!("\"{from}\": not used; {figures}"));
            continue;
        };
        for doubt in &guess.doubts {
            remark(&mut lines, &format!("doubt: {}, {doubt}", guess.to));
        }
        if guess.to == column.name && guess.unit.is_none() && !guess.turned {
            let unit = unit_of_run(guess);
            remark(&mut lines, &format!("{}: has its name already, in {unit}; {figures}", guess.to));
            continue;
        }
        let unit = guess.unit.map_or_else(String::new, |unit| format!(", unit = \"{unit}\""));
        let scale = guess.scale.map_or_else(String::new, |scale| format!(", scale = {scale:?}"));
        let sign = if guess.turned { ", sign = -1.0" } else { "" };
        let figures = reword(&figures);
        lines.push(format!("{} = {{ from = \"{from}\"{unit}{scale}{sign} }}    # {figures}", guess.to));
    }
    let has = |quantity: Quantity| {
        let of = |to: &str| (1..=4).any(|wheelsets| quantity.column(0, wheelsets) == to);
        surveyed.iter().filter_map(|column| column.guess.as_ref()).any(|guess| of(&guess.to))
    };
    for quantity in Quantity::ALL.into_iter().filter(|quantity| quantity.required() && !has(*quantity)) {
        remark(&mut lines, &format!("missing: {} ({})", quantity.column(0, 2), quantity.unit()));
    }
    lines.join("\n")
}

/// What is in a column, as a sentence.
fn figures(column: &Surveyed) -> String {
    match column.figures {
        Some((count, least, most)) if count > 0 => format!("{count} numbers, {least} to {most}"),
        Some(_) => "empty".to_owned(),
        None => "no numbers".to_owned(),
    }
}
