//! TLS: where it is asked for nothing else is spoken, and its certificate is renewed.

use crate::service::{PATIENCE, Service, rest, within};
use railgrip_settings::{Overrides, TrainSettings};
use std::io::Write;
use std::path::Path;

#[test]
fn nothing_but_tls_is_spoken_where_tls_is_asked_for() {
    let service = Service::start("[http.limits]\nhead_s = 0.5\n", true);
    let mut plain = service.socket();
    plain.write_all(b"GET /health/live HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let (said, _) = rest(&mut plain);
    assert!(!said.contains("HTTP/1.1"), "{said:?}");
    let mut silent = service.socket();
    let (_, took) = rest(&mut silent);
    println!("a handshake that never comes is cut off after {:.2} s", took.as_secs_f64());
    assert!(took < PATIENCE);
    let (_, headers, _) = service.get("/health/live", &[]);
    assert!(headers.contains("strict-transport-security: max-age=31536000"), "{headers}");
}

#[test]
fn a_certificate_is_renewed_without_a_restart() {
    let mut service = Service::start("", true);
    assert_eq!(service.get("/health/live", &[]).0, 200);
    let made = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
    std::fs::write(service.file("key.pem"), made.signing_key.serialize_pem()).unwrap();
    std::fs::write(service.file("cert.pem"), made.cert.pem()).unwrap();
    service.certificate = Some(made.cert.pem());
    let speaks = || service.agent().get(service.url("/health/live")).call().is_ok();
    assert!(within(PATIENCE, speaks), "the new certificate is trusted by its own root only");
}

#[test]
fn an_address_beyond_loopback_asks_for_tls_and_tokens() {
    let text = format!(
        "schema = 1\n[train]\nname = \"access\"\nwagons = 1\nvehicle = \"{}/../../config/vehicle.toml\"\n[source]\nkind = \"stdin\"\n[http]\nlisten = \"0.0.0.0:0\"\n",
        env!("CARGO_MANIFEST_DIR")
    );
    let said =
        TrainSettings::parse(Path::new("train.toml"), &text, &Overrides::default()).unwrap_err().to_string();
    println!("{said}");
    assert!(said.contains("`http.listen`") && said.contains("certificate") && said.contains("token_file"));
}
