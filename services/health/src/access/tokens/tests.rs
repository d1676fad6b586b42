use super::*;
use crate::access::role::Role;
use crate::time::unix_s;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::path::PathBuf;

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("tokens.toml");
    (folder, file)
}

#[test]
fn a_token_is_made_found_rotated_and_revoked() {
    let (_folder, file) = folder();
    let secret = add(&file, "depot", Role::Acknowledge, None).expect("add");
    assert_eq!(secret.len(), PREFIX.len() + 64);
    let text = std::fs::read_to_string(&file).expect("read");
    assert!(!text.contains(&secret) && !text.contains(&secret[PREFIX.len()..]), "{text}");
    assert_eq!(std::fs::metadata(&file).expect("file").mode() & 0o777, 0o600);

    let book = TokenBook::open(&file).expect("open");
    let now = unix_s();
    let role = |secret: &str, now| book.of_secret(secret, now).map(|token| token.role);
    assert_eq!(role(&secret, now), Some(Role::Acknowledge));
    assert_eq!(role("railgrip_0", now), None);
    assert_eq!(role(&secret[1..], now), None);
    assert_eq!(book.look(), None, "unchanged");

    let renewed = rotate(&file, "depot", 60).expect("rotate");
    assert_eq!(book.look().as_deref(), Some("1 tokens"));
    assert_eq!((role(&secret, now), role(&renewed, now)), (Some(Role::Acknowledge), Some(Role::Acknowledge)));
    assert_eq!((role(&secret, now + 90), role(&renewed, now + 90)), (None, Some(Role::Acknowledge)));

    revoke(&file, "depot").expect("revoke");
    assert_eq!(book.look().as_deref(), Some("0 tokens"));
    assert_eq!(role(&renewed, now), None);
    let said = revoke(&file, "depot").expect_err("gone").to_string();
    assert!(said.contains("there is no token \"depot\"; there is none"), "{said}");
}

#[test]
fn tokens_end_at_their_time() {
    let (_folder, file) = folder();
    let secret = add(&file, "short", Role::Read, Some(unix_s() + 100)).expect("add");
    let book = TokenBook::open(&file).expect("open");
    assert!(book.of_secret(&secret, unix_s()).is_some());
    assert!(book.of_secret(&secret, unix_s() + 101).is_none());
}

#[test]
fn a_file_gone_lets_nobody_in_and_one_not_understood_changes_nothing() {
    let (_folder, file) = folder();
    let secret = add(&file, "depot", Role::Read, None).expect("add");
    let book = TokenBook::open(&file).expect("open");
    let text = std::fs::read_to_string(&file).expect("read");
    std::fs::write(&file, &text[..text.len() / 2]).expect("write");
    assert!(book.look().expect("changed").starts_with("refused"));
    assert!(book.of_secret(&secret, unix_s()).is_some());
    std::fs::remove_file(&file).expect("remove");
    assert_eq!(book.look().as_deref(), Some("0 tokens"));
    assert!(book.of_secret(&secret, unix_s()).is_none());
}

#[test]
fn mistakes_are_named() {
    let good = "schema = 1\n[[token]]\nname = \"a\"\nrole = \"read\"\nsha256 = \"HASH\"\ncreated = \"2026-03-01T12:00:00Z\"\n"
        .replace("HASH", &"0".repeat(64));
    let said = |text: &str| parse(Path::new("t.toml"), text).expect_err("wrong").to_string();
    assert_eq!(parse(Path::new("t.toml"), &good).expect("good").len(), 1);
    for (from, to, words) in [
        ("schema = 1", "schema = 2", "t.toml: `schema` is 2, allowed is 1"),
        ("\"read\"", "\"reed\"", "line 4: unknown variant `reed`"),
        ("0000\"", "000\"", "token 1: `sha256` is not the 64"),
        ("2026-03-01T", "2026-03-41T", "token 1: `created` is"),
        ("\"a\"", "\"a b\"", "token 1: name \"a b\""),
        ("\"a\"", "\"local\"", "not `local`"),
    ] {
        let said = said(&good.replace(from, to));
        assert!(said.contains(words), "{said}");
    }
    let twice = format!("{good}{}", &good["schema = 1\n".len()..]);
    assert!(said(&twice).contains("token 2: there are two of the name"), "{}", said(&twice));
}

#[test]
fn a_file_that_others_may_write_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let (_folder, file) = folder();
    add(&file, "depot", Role::Read, None).expect("add");
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o620)).expect("chmod");
    let said = read(&file).expect_err("refused").to_string();
    assert!(said.contains("mode is 620") && said.contains("chmod 600"), "{said}");
}
