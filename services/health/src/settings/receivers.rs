//! Receivers of alerts in the config file: added, changed and removed in place.
//!
//! What a secret goes with stays under the file's own rule: files with tokens and passwords are named in the config file only,
//! and a receiver that has one keeps its address here, so that no page can send a secret elsewhere.

use super::file::{ChangeError, RECEIVER, document, noted, rewrite};
use super::model::{ReceiverKind, ReceiverRequest};
use railgrip_settings::has_login;
use std::path::Path;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value, value};

/// Keys that say where a receiver is, and by what it is known there.
const ADDRESS: [&str; 5] = ["url", "host", "port", "tls", "ca_file"];
/// Keys that name a file with a secret.
const SECRETS: [&str; 2] = ["token_file", "password_file"];

/// Does to `file` what `request` asks for. `note` says who, when and why; it becomes the comment above the receiver, or at the
/// end of the file where one is removed. Everything else in the file stays as it is.
///
/// # Errors
/// A receiver that is not there, what the check of the whole file refuses, or a file that cannot be read or written. The file
/// is then as before.
pub fn change_receiver(file: &Path, request: &ReceiverRequest, note: &str) -> Result<(), ChangeError> {
    rewrite(file, |text| edit(text, request, note))
}

fn edit(text: &str, request: &ReceiverRequest, note: &str) -> Result<String, ChangeError> {
    let mut document = document(text)?;
    if let Some(old) = document.get("delivery").and_then(Item::as_table_like)
        && (old.contains_key("webhook") || old.contains_key("mqtt"))
    {
        return form(
            "the file names receivers in its old form, [delivery]; write them as [[receiver]] to change them here",
        );
    }
    let receivers = receivers(&mut document)?;
    let names = pin_names(receivers);
    let at = names.iter().position(|name| *name == request.name);
    let word = match (at, request.remove) {
        (None, true) => return Err(ChangeError::NoReceiver(request.name.clone())),
        (Some(at), true) => {
            receivers.remove(at);
            "removed"
        }
        (Some(at), false) => {
            let Some(table) = receivers.get_mut(at) else { return form("the receiver is no table") };
            replace(table, request)?;
            let before = table.decor().prefix().and_then(|raw| raw.as_str()).unwrap_or_default().to_owned();
            table.decor_mut().set_prefix(noted(&before, RECEIVER, &line(request, "changed", note)));
            return Ok(document.to_string());
        }
        (None, false) => {
            let mut table = Table::new();
            let Some(kind) = request.kind else { return form("a new receiver needs its `kind`") };
            table.insert("kind", value(kind.word()));
            table.insert("name", value(&request.name));
            set(&mut table, request);
            table.decor_mut().set_prefix(noted("\n", RECEIVER, &line(request, "added", note)));
            receivers.push(table);
            return Ok(document.to_string());
        }
    };
    let end = document.trailing().as_str().unwrap_or_default().to_owned();
    document.set_trailing(format!("{end}# {}\n", line(request, word, note)));
    Ok(document.to_string())
}

fn line(request: &ReceiverRequest, word: &str, note: &str) -> String {
    format!("{RECEIVER}{} {word} {note}", request.name)
}

fn form<T>(words: &str) -> Result<T, ChangeError> {
    Err(ChangeError::Form(words.to_owned()))
}

/// The tables `[[receiver]]`, which may be none yet.
fn receivers(document: &mut DocumentMut) -> Result<&mut ArrayOfTables, ChangeError> {
    let item = document.entry("receiver").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    let Some(tables) = item.as_array_of_tables_mut() else {
        return form(
            "`receiver` is written in one line; make each a table [[receiver]] of its own to change it here",
        );
    };
    Ok(tables)
}

/// The names of the receivers. One that has none is named by its place among its kind; such a name is written down, because
/// the notifications that wait belong to it, and places change.
fn pin_names(receivers: &mut ArrayOfTables) -> Vec<String> {
    let mut webhooks = 0;
    let mut pinned = Vec::new();
    for table in receivers.iter_mut() {
        let is_webhook = table.get("kind").and_then(Item::as_str) == Some(ReceiverKind::Webhook.word());
        webhooks += u32::from(is_webhook);
        let default = if is_webhook { format!("webhook-{webhooks}") } else { "mqtt".to_owned() };
        if !table.contains_key("name") {
            table.insert("name", value(&default));
        }
        pinned.push(table.get("name").and_then(Item::as_str).unwrap_or(&default).to_owned());
    }
    pinned
}

/// Changes one that is there; what the request leaves open stays.
fn replace(table: &mut Table, request: &ReceiverRequest) -> Result<(), ChangeError> {
    let kind = table.get("kind").and_then(Item::as_str);
    if request.kind.is_some_and(|new| kind != Some(new.word())) {
        return form("the kind of a receiver stays; remove it and add another");
    }
    let address =
        |table: &Table| ADDRESS.map(|key| table.get(key).map(|item| item.to_string().trim().to_owned()));
    let before = address(table);
    let login = table.get("url").and_then(Item::as_str).is_some_and(has_login);
    let secret = login || SECRETS.iter().any(|key| table.contains_key(key));
    set(table, request);
    if secret && address(table) != before {
        return form("this receiver is sent a secret; its address and its TLS are changed in the file only");
    }
    Ok(())
}

fn set(table: &mut Table, request: &ReceiverRequest) {
    let text = |text: &Option<String>| text.as_ref().map(Value::from);
    let new: [(&str, Option<Value>); 7] = [
        ("url", text(&request.url)),
        ("host", text(&request.host)),
        ("port", request.port.map(|port| Value::from(i64::from(port)))),
        ("topic", text(&request.topic)),
        ("tls", request.tls.map(Value::from)),
        ("ca_file", text(&request.ca_file).filter(|_| request.ca_file.as_deref() != Some(""))),
        ("grade", request.grade.map(|grade| Value::from(grade.word()))),
    ];
    // Without TLS, or where the public ones shall hold, the file names no authorities.
    if request.tls == Some(false) || request.ca_file.as_deref() == Some("") {
        table.remove("ca_file");
    }
    for (key, new) in new {
        let Some(mut new) = new else { continue };
        match table.get_mut(key).and_then(Item::as_value_mut) {
            // A comment behind the value stays there.
            Some(old) => {
                *new.decor_mut() = old.decor().clone();
                *old = new;
            }
            None => {
                table.insert(key, Item::Value(new));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::model::LeastGrade;

    const FILE: &str = "# the train\n[train]\nname = \"t\"\n\n# the depot, since May\n[[receiver]]\nkind = \"webhook\"\nurl = \"https://depot/a\" # theirs\n\n\
                        [[receiver]]\nkind = \"webhook\"\nurl = \"https://night/a\"\ntoken_file = \"night.token\"\n\n[alerts]\nraise_after_s = 3.0\n";

    fn ask(name: &str) -> ReceiverRequest {
        ReceiverRequest { name: name.to_owned(), why: "w".to_owned(), ..ReceiverRequest::default() }
    }

    #[test]
    fn a_change_keeps_comments_and_order_and_says_who() {
        let act = ReceiverRequest { grade: Some(LeastGrade::Act), ..ask("webhook-1") };
        let once = edit(FILE, &act, "by kim").unwrap();
        let expected = FILE.replace(
            "# the depot, since May\n[[receiver]]\nkind = \"webhook\"\nurl = \"https://depot/a\" # theirs\n",
            "# the depot, since May\n# receiver webhook-1 changed by kim\n[[receiver]]\nkind = \"webhook\"\nurl = \"https://depot/a\" # theirs\nname = \"webhook-1\"\ngrade = \"act\"\n",
        );
        let expected = expected.replace("\"night.token\"\n", "\"night.token\"\nname = \"webhook-2\"\n");
        assert_eq!(once, expected);
        let moved = ReceiverRequest { url: Some("https://depot/b".to_owned()), ..ask("webhook-1") };
        let twice = edit(&once, &moved, "by lee").unwrap();
        assert!(twice.contains("url = \"https://depot/b\" # theirs\n"), "{twice}");
        assert!(twice.contains("changed by lee") && !twice.contains("by kim"), "{twice}");
    }

    #[test]
    fn one_is_added_and_another_removed_without_renaming_the_rest() {
        let new = ReceiverRequest {
            kind: Some(ReceiverKind::Mqtt),
            host: Some("broker".to_owned()),
            port: Some(1884),
            ..ask("yard")
        };
        let added = edit(FILE, &new, "by kim").unwrap();
        assert!(
            added.contains("# receiver yard added by kim\n[[receiver]]\nkind = \"mqtt\"\nname = \"yard\"\nhost = \"broker\"\nport = 1884\n"),
            "{added}"
        );
        let removed = edit(&added, &ReceiverRequest { remove: true, ..ask("webhook-1") }, "by lee").unwrap();
        let table: toml::Table = removed.parse().unwrap();
        let names: Vec<_> =
            table["receiver"].as_array().unwrap().iter().map(|one| one["name"].as_str()).collect();
        assert_eq!(names, [Some("webhook-2"), Some("yard")], "{removed}");
        assert!(removed.ends_with("# receiver webhook-1 removed by lee\n"), "{removed}");
        assert_eq!(table["alerts"]["raise_after_s"].as_float(), Some(3.0));
        // The first one of a file that names none.
        let first = edit("[train]\nname = \"t\"\n", &new, "by kim").unwrap();
        assert!(first.starts_with("[train]\nname = \"t\"\n") && first.contains("[[receiver]]"), "{first}");
    }

    #[test]
    fn tls_of_a_broker_is_switched_on_and_off() {
        let plain = "[[receiver]]\nkind = \"mqtt\"\nname = \"yard\"\nhost = \"broker\" # theirs\n";
        let tls = |on: bool, file: Option<&str>| ReceiverRequest {
            tls: Some(on),
            ca_file: file.map(str::to_owned),
            ..ask("yard")
        };
        let on = edit(plain, &tls(true, Some("ca.pem")), "by kim").unwrap();
        assert!(on.contains("host = \"broker\" # theirs\ntls = true\nca_file = \"ca.pem\"\n"), "{on}");
        let public = edit(&on, &tls(true, Some("")), "by kim").unwrap();
        assert!(public.contains("tls = true\n") && !public.contains("ca_file"), "{public}");
        let off = edit(&on, &tls(false, None), "by kim").unwrap();
        assert!(off.contains("tls = false\n") && !off.contains("ca_file"), "{off}");
        let secret = on + "user = \"u\"\npassword_file = \"p\"\n";
        for weaker in [tls(false, None), tls(true, Some("theirs.pem")), tls(true, Some(""))] {
            let said = edit(&secret, &weaker, "by kim");
            assert!(matches!(said, Err(ChangeError::Form(said)) if said.contains("TLS")), "{weaker:?}");
        }
    }

    #[test]
    fn no_secret_is_sent_elsewhere_and_old_forms_are_left_alone() {
        let night = ask("webhook-2");
        let elsewhere = ReceiverRequest { url: Some("https://elsewhere/a".to_owned()), ..night.clone() };
        assert!(
            matches!(edit(FILE, &elsewhere, "by kim"), Err(ChangeError::Form(said)) if said.contains("secret"))
        );
        let login = FILE.replace("https://depot/a", "https://kim:word@depot/a");
        let moved = ReceiverRequest { url: elsewhere.url.clone(), ..ask("webhook-1") };
        assert!(
            matches!(edit(&login, &moved, "by kim"), Err(ChangeError::Form(said)) if said.contains("secret"))
        );
        assert!(
            edit(FILE, &ReceiverRequest { grade: Some(LeastGrade::Act), ..night.clone() }, "by kim").is_ok()
        );
        let other_kind = ReceiverRequest { kind: Some(ReceiverKind::Mqtt), ..ask("webhook-1") };
        assert!(matches!(edit(FILE, &other_kind, "by kim"), Err(ChangeError::Form(_))));
        assert!(
            matches!(edit(FILE, &ask("new"), "by kim"), Err(ChangeError::Form(said)) if said.contains("kind"))
        );
        let gone = ReceiverRequest { remove: true, ..ask("new") };
        assert!(matches!(edit(FILE, &gone, "by kim"), Err(ChangeError::NoReceiver(_))));
        let old = "[[delivery.webhook]]\nurl = \"https://depot/a\"\n";
        assert!(
            matches!(edit(old, &gone, "by kim"), Err(ChangeError::Form(said)) if said.contains("old form"))
        );
        let one_line = "receiver = [{ kind = \"mqtt\", host = \"b\" }]\n";
        assert!(
            matches!(edit(one_line, &gone, "by kim"), Err(ChangeError::Form(said)) if said.contains("one line"))
        );
    }
}
