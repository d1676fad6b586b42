//! What only paper shows: lines for the fitter to write on, and where the page came from.

use maud::{Markup, html};
use railgrip_words::t;

/// Blank lines, and the address of the view that was printed; the script writes it, with the range of the charts.
pub(super) fn lines() -> Markup {
    html! {
        section .paper aria-hidden="true" {
            dl {
                @for name in ["Found", "Done", "Parts, measured values", "Name, date, signature"] {
                    div { dt { (t(name)) } dd {} }
                }
            }
            p #printed-from {}
            p { (t("Printed are at most four alerts and eight lines of a table; all of them stand at that address.")) }
        }
    }
}
