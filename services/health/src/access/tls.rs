//! HTTPS by rustls with the provider `ring`: TLS 1.2 and 1.3, no other cipher suites than rustls' own, HTTP/1.1 only.
//!
//! `ring` rather than `aws-lc-rs`: it builds with a C compiler alone, in seconds. Certificate and key are read again
//! within a second when their files change; a pair that does not fit together leaves the one before in use.

use crate::access::error::AccessError;
use railgrip_settings::TlsFiles;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::{CryptoProvider, ring};
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::{ClientHello, ResolvesServerCert};
use tokio_rustls::rustls::sign::CertifiedKey;

/// What tells whether a file is another than before.
type Mark = Option<(i64, i64, u64, u64)>;

/// Certificate and key, renewed when their files change.
pub(super) struct Tls {
    files: TlsFiles,
    current: Arc<Current>,
    acceptor: TlsAcceptor,
    seen: Mutex<[Mark; 2]>,
}

#[derive(Debug)]
struct Current(RwLock<Arc<CertifiedKey>>);

impl ResolvesServerCert for Current {
    fn resolve(&self, _hello: ClientHello<'_>) -> Option<Arc<CertifiedKey>> {
        Some(Arc::clone(&self.0.read().unwrap_or_else(PoisonError::into_inner)))
    }
}

impl Tls {
    pub(super) fn load(files: &TlsFiles) -> Result<Self, AccessError> {
        let provider = Arc::new(ring::default_provider());
        let seen = Mutex::new(marks(files));
        let current = Arc::new(Current(RwLock::new(Arc::new(pair(files, &provider)?))));
        let wrong = |error: tokio_rustls::rustls::Error| AccessError::Pem {
            file: files.certificate.clone(),
            problem: error.to_string(),
        };
        let mut config = ServerConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .map_err(wrong)?
            .with_no_client_auth()
            .with_cert_resolver(Arc::clone(&current) as Arc<dyn ResolvesServerCert>);
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self { files: files.clone(), current, acceptor: Arc::new(config).into(), seen })
    }

    pub(super) fn acceptor(&self) -> TlsAcceptor {
        self.acceptor.clone()
    }

    /// Reads the files again if they are others; says what came of it.
    pub(super) fn look(&self) -> Option<Result<(), String>> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let now = marks(&self.files);
        if *seen == now {
            return None;
        }
        *seen = now;
        let provider = ring::default_provider();
        Some(match pair(&self.files, &provider) {
            Ok(pair) => {
                tracing::info!("{}: a new certificate is in use", self.files.certificate.display());
                *self.current.0.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(pair);
                Ok(())
            }
            Err(error) => {
                tracing::error!("{error}; the certificate before stays in use");
                Err(format!("refused: {error}"))
            }
        })
    }
}

fn marks(files: &TlsFiles) -> [Mark; 2] {
    [&files.certificate, &files.key].map(|file| {
        let metadata = std::fs::metadata(file).ok()?;
        Some((metadata.mtime(), metadata.mtime_nsec(), metadata.ino(), metadata.len()))
    })
}

fn pair(files: &TlsFiles, provider: &CryptoProvider) -> Result<CertifiedKey, AccessError> {
    let wrong = |file: &Path, problem: String| AccessError::Pem { file: file.to_owned(), problem };
    let text = read(&files.certificate)?;
    let chain: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
    let chain = chain.map_err(|error| wrong(&files.certificate, error.to_string()))?;
    if chain.is_empty() {
        return Err(wrong(&files.certificate, "holds no `BEGIN CERTIFICATE`".to_owned()));
    }
    let key = PrivateKeyDer::from_pem_slice(&read(&files.key)?).map_err(|_| {
        let problem = "holds no private key without a passphrase (PKCS#8, PKCS#1 or SEC1)";
        wrong(&files.key, problem.to_owned())
    })?;
    if let Ok(metadata) = std::fs::metadata(&files.key)
        && metadata.mode() & 0o007 != 0
    {
        tracing::warn!("{}: everybody on this machine may read the private key", files.key.display());
    }
    CertifiedKey::from_der(chain, key, provider).map_err(|error| {
        wrong(&files.key, format!("does not fit to {}: {error}", files.certificate.display()))
    })
}

fn read(file: &Path) -> Result<Vec<u8>, AccessError> {
    std::fs::read(file).map_err(|source| AccessError::File { file: file.to_owned(), source })
}
