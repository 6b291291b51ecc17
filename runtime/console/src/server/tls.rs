use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::sync::Arc;

use rustls::ServerConfig;
use rustls::crypto::ring::default_provider;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::TlsAcceptor;

use super::ServerError;

/// A larger file is no certificate and no key, bytes.
const FILE_MAX: u64 = 1 << 20;

/// A certificate and its key, with which other computers can reach the console: TLS 1.2 and 1.3.
#[derive(Clone)]
pub struct Tls(pub(super) TlsAcceptor);

impl Tls {
    /// Reads a certificate (with those that vouch for it, if any) and its private key, both in PEM.
    ///
    /// # Errors
    ///
    /// [`ServerError::Tls`] if a file cannot be read, if others can read the key, or if the two do not belong together.
    pub fn read(certificate: &Path, key: &Path) -> Result<Self, ServerError> {
        let (certificate_pem, _) = read(certificate)?;
        let chain: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&certificate_pem).collect();
        let chain = chain.map_err(|error| wrong(certificate, format!("no certificate in PEM: {error}")))?;
        if chain.is_empty() {
            return Err(wrong(certificate, "no certificate in PEM: is this the key?".to_owned()));
        }
        let (key_pem, mode) = read(key)?;
        let private = PrivateKeyDer::from_pem_slice(&key_pem)
            .map_err(|error| wrong(key, format!("no private key in PEM: {error}")))?;
        if mode & 0o077 != 0 {
            let mode = mode & 0o777;
            return Err(wrong(
                key,
                format!("mode {mode:03o} lets others read the key: chmod 600"),
            ));
        }
        let config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
            .with_safe_default_protocol_versions()
            .and_then(|builder| builder.with_no_client_auth().with_single_cert(chain, private))
            .map_err(|error| wrong(key, format!("cannot be used with {}: {error}", certificate.display())))?;
        Ok(Self(TlsAcceptor::from(Arc::new(config))))
    }
}

impl std::fmt::Debug for Tls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Tls")
    }
}

/// The bytes of a file, and its mode.
fn read(path: &Path) -> Result<(Vec<u8>, u32), ServerError> {
    let unread = |error: std::io::Error| wrong(path, error.to_string());
    let found = path.metadata().map_err(unread)?;
    if !found.is_file() || found.len() > FILE_MAX {
        return Err(wrong(path, "not a file in PEM".to_owned()));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| {
        if error.kind() == ErrorKind::PermissionDenied {
            let to_do = "chown it to the user as whom this program runs, and chmod 600";
            wrong(path, format!("{error}: {to_do}"))
        } else {
            unread(error)
        }
    })?;
    file.take(FILE_MAX).read_to_end(&mut bytes).map_err(unread)?;
    Ok((bytes, found.mode()))
}

fn wrong(path: &Path, reason: String) -> ServerError {
    ServerError::Tls {
        path: path.to_owned(),
        reason,
    }
}
