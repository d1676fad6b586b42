//! Paper against ours, as CSV and Markdown.

/// One figure.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Part of the experiment.
    pub group: String,
    /// What is measured.
    pub quantity: String,
    /// Unit; empty for pure numbers.
    pub unit: &'static str,
    /// The paper's figure, if it gives one.
    pub paper: Option<f64>,
    /// Ours.
    pub ours: f64,
    /// What else must be known to read it.
    pub remark: String,
}

/// Figures in reading order.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Rows.
    pub rows: Vec<Row>,
}

/// Something that must hold.
#[derive(Clone, Debug)]
pub struct Criterion {
    /// What.
    pub name: String,
    /// What was measured.
    pub figure: String,
    /// Whether it holds.
    pub met: bool,
}

impl Row {
    /// Ours minus the paper's.
    pub fn difference(&self) -> Option<f64> {
        self.paper.map(|paper| self.ours - paper)
    }
}

impl Table {
    /// Adds a row.
    pub fn push(
        &mut self,
        group: impl Into<String>,
        quantity: impl Into<String>,
        unit: &'static str,
        paper: Option<f64>,
        ours: f64,
        remark: impl Into<String>,
    ) {
        self.rows.push(Row {
            group: group.into(),
            quantity: quantity.into(),
            unit,
            paper,
            ours,
            remark: remark.into(),
        });
    }

    /// The row of a group and quantity.
    pub fn find(&self, group: &str, quantity: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.group == group && row.quantity == quantity)
    }

    /// As CSV: `group,quantity,unit,paper,ours,difference,remark`.
    pub fn csv(&self) -> String {
        let mut text = String::from("group,quantity,unit,paper,ours,difference,remark\n");
        for row in &self.rows {
            let optional = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
            text.push_str(&format!(
                "{},{},{},{},{},{},{}\n",
                quoted(&row.group),
                quoted(&row.quantity),
                row.unit,
                optional(row.paper),
                row.ours,
                optional(row.difference()),
                quoted(&row.remark)
            ));
        }
        text
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::from(
            "| part | quantity | unit | paper | ours | difference | remark |\n|---|---|---|---:|---:|---:|---|\n",
        );
        for row in &self.rows {
            let optional = |value: Option<f64>| value.map(short).unwrap_or_default();
            text.push_str(&format!(
                "| {} | {} | {} | {} | {} | {} | {} |\n",
                row.group,
                row.quantity,
                row.unit,
                optional(row.paper),
                short(row.ours),
                optional(row.difference()),
                row.remark
            ));
        }
        text
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Four significant digits.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..=6).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let decimals = (3 - magnitude).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_out_in_both_forms() {
        let mut table = Table::default();
        table.push("base", "mean, filter", "", Some(0.28), 0.2797, "seed 1");
        table.push("base", "step", "µs", None, 12.5, "");
        assert!(table.csv().contains("base,\"mean, filter\",,0.28,0.2797,"));
        assert!(table.markdown().contains("| base | mean, filter |  | 0.28 | 0.2797 | -0.0003 | seed 1 |"));
        assert!(table.find("base", "step").unwrap().difference().is_none());
        assert_eq!(short(1234567.0), "1234567");
        assert_eq!(short(1.5e-6), "1.50e-6");
    }
}
