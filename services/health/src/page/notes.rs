//! Notes on a vehicle: what people wrote down, and a form to write more.

use maud::{Markup, html};
use railgrip_words::t;

/// The section of a wagon's page; its script fills it and sends.
pub(super) fn section(id: u32, numbered: bool) -> Markup {
    html! {
        details .card #fold-notes {
            summary { h2 { (t("Notes on this vehicle")) } }
            @if !numbered {
                p .calm { (t("This wagon has no vehicle number: what is written down here counts until the train is started again.")) }
            }
            div #notes data-wagon=(id) aria-live="polite" { p .calm { (t("Loading notes…")) } }
            form #note-form .note-form {
                label { (t("Your name or initials")) " " input #note-by name="by" autocomplete="name" maxlength="100"; }
                label { (t("Note")) " " input #note-text name="text" maxlength="500"; }
                label .tick { input #note-pads type="checkbox" name="pads"; " " (t("Brake pads were changed: pad friction trends begin anew")) }
                p #note-error .error role="alert" {}
                button type="submit" .primary { (t("Write down")) }
            }
        }
    }
}
