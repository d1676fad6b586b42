//! Which pages there are, and the pieces that they are made of.

use maud::Markup;

/// Which page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Page {
    Train,
    Wagon(u32),
    Alerts,
    Meaning,
    Settings,
}

/// A piece of a page that renews itself.
pub(super) struct Part {
    /// `id` of its element.
    pub id: String,
    /// The element.
    pub html: Markup,
}

impl Part {
    /// A piece of that `id`.
    pub fn new(id: impl Into<String>, html: Markup) -> Self {
        Self { id: id.into(), html }
    }
}

impl Page {
    /// As the query of `/live` names it.
    pub fn parse(text: &str) -> Option<Self> {
        match text {
            "train" => Some(Self::Train),
            "alerts" => Some(Self::Alerts),
            "indicators" => Some(Self::Meaning),
            "settings" => Some(Self::Settings),
            _ => text.strip_prefix("wagon-")?.parse().ok().map(Self::Wagon),
        }
    }

    /// Its name in the query of `/live`.
    pub fn key(self) -> String {
        match self {
            Self::Train => "train".to_owned(),
            Self::Alerts => "alerts".to_owned(),
            Self::Meaning => "indicators".to_owned(),
            Self::Settings => "settings".to_owned(),
            Self::Wagon(id) => format!("wagon-{id}"),
        }
    }
}
