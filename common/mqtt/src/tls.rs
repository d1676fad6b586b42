//! Whom we believe to be the broker: rustls with the provider `ring`, TLS 1.2 and 1.3, as everywhere in this project.

use crate::error::MqttError;
use rustls::crypto::ring;
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject;
use rustls::{ClientConfig, RootCertStore};
use std::path::Path;
use std::sync::Arc;

/// Who may have signed a broker's certificate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Authorities<'a> {
    /// The public ones (Mozilla's).
    Public,
    /// Those of a PEM file.
    File(&'a Path),
}

impl<'a> Authorities<'a> {
    /// Those of a file, or the public ones without it.
    #[must_use]
    pub fn of(file: Option<&'a Path>) -> Self {
        file.map_or(Self::Public, Self::File)
    }

    /// Whether they can be used.
    ///
    /// # Errors
    /// A file that cannot be read, or that holds no certificate or a broken one.
    pub fn check(self) -> Result<(), MqttError> {
        config(self).map(|_| ())
    }
}

/// The config by which a certificate is checked.
pub(crate) fn config(authorities: Authorities<'_>) -> Result<Arc<ClientConfig>, MqttError> {
    let roots = match authorities {
        Authorities::Public => RootCertStore { roots: webpki_roots::TLS_SERVER_ROOTS.to_vec() },
        Authorities::File(file) => {
            read(file).map_err(|problem| MqttError::Authorities { file: file.to_owned(), problem })?
        }
    };
    let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(|error| MqttError::Tls(error.to_string()))?
        .with_root_certificates(roots)
        .with_no_client_auth();
    Ok(Arc::new(config))
}

fn read(file: &Path) -> Result<RootCertStore, String> {
    let text = std::fs::read(file).map_err(|error| error.to_string())?;
    let mut roots = RootCertStore::empty();
    for certificate in CertificateDer::pem_slice_iter(&text) {
        let certificate = certificate.map_err(|error| error.to_string())?;
        roots.add(certificate).map_err(|error| error.to_string())?;
    }
    if roots.is_empty() {
        return Err("holds no `BEGIN CERTIFICATE`".to_owned());
    }
    Ok(roots)
}
