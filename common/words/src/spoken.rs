//! The language that is spoken now.

use super::language::Language;
use std::cell::Cell;

thread_local! {
    static SPOKEN: Cell<Language> = const { Cell::new(Language::English) };
}

/// Has `render` speak this language.
pub fn speak<T>(language: Language, render: impl FnOnce() -> T) -> T {
    struct Back(Language);
    impl Drop for Back {
        fn drop(&mut self) {
            SPOKEN.set(self.0);
        }
    }
    let _back = Back(SPOKEN.replace(language));
    render()
}

/// The language that is spoken now.
pub fn spoken() -> Language {
    SPOKEN.get()
}
