//! TLS with the certificate that the settings name.

use std::path::Path;
use std::sync::Arc;

use rustls::ServerConfig;
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::TlsAcceptor;

use crate::Error;
use crate::settings::Identity;

/// The largest file of a certificate or a key, bytes.
const MAX_FILE: u64 = 1 << 20;

/// Reads a certificate and its key.
///
/// # Errors
/// [`Error::Certificate`] names the file and the reason.
pub(crate) fn acceptor(identity: &Identity) -> Result<TlsAcceptor, Error> {
    let (certificate, key) = (&identity.certificate, &identity.key);
    let text = read(certificate)?;
    let chain: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(text.as_bytes()).collect();
    let chain = chain.map_err(|error| fault(certificate, error))?;
    if chain.is_empty() {
        return Err(fault(certificate, "it contains no certificate"));
    }
    let secret = PrivateKeyDer::from_pem_slice(read(key)?.as_bytes()).map_err(|error| fault(key, error))?;
    let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(|error| fault(certificate, error))?
        .with_no_client_auth()
        .with_single_cert(chain, secret)
        .map_err(|error| fault(key, error))?;
    Ok(TlsAcceptor::from(Arc::new(config)))
}

fn read(file: &Path) -> Result<String, Error> {
    jde_files::read_text(file, MAX_FILE).map_err(|error| fault(file, error))
}

fn fault(file: &Path, reason: impl ToString) -> Error {
    Error::Certificate {
        file: file.display().to_string(),
        reason: reason.to_string(),
    }
}
