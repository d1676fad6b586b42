//! Each page, put together from its pieces.

use super::kind::{Page, Part};
use super::{alerts, frame, meaning, settings, train, wagon};
use crate::settings::{receiver_routes, routes::list};
use crate::shared::Shared;
use crate::store::Snapshot;
use maud::Markup;
use railgrip_words::{say, t};

/// Everything that renews itself on this page.
pub(super) fn parts(page: Page, shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
    let mut parts = frame::parts(shared, snapshot);
    parts.extend(match page {
        Page::Train => train::parts(shared, snapshot),
        Page::Alerts => alerts::parts(shared, snapshot),
        Page::Meaning | Page::Settings => Vec::new(),
        Page::Wagon(id) => wagon::parts(id, &shared.limits(), snapshot),
    });
    parts
}

/// A whole page.
pub(super) fn document(page: Page, shared: &Shared, snapshot: &Snapshot) -> Markup {
    let (title, body) = match page {
        Page::Train => (t("Train").to_owned(), train::body(shared, snapshot)),
        Page::Alerts => (t("Alerts").to_owned(), alerts::body(shared, snapshot)),
        Page::Settings => {
            let body = settings::body(&list(shared), &receiver_routes::list(shared));
            (t("Thresholds and receivers").to_owned(), body)
        }
        Page::Meaning => (t("What the figures mean").to_owned(), meaning::body(&shared.limits())),
        Page::Wagon(id) => {
            (say("Wagon {number}", &[("number", &id)]), wagon::body(id, &shared.limits(), snapshot))
        }
    };
    frame::document(page, &title, shared, snapshot, &body)
}
