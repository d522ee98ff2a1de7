//! The concealed cases and the seal on their truths.

use anyhow::{Context, Result, bail};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The cases of one level, and the SHA-256 of their truths that the plant printed.
pub(crate) struct Sealed {
    pub(crate) level: u8,
    pub(crate) cases: PathBuf,
    pub(crate) truths: PathBuf,
    pub(crate) sha256: String,
    pub(crate) ids: Vec<String>,
}

/// What the plant is to make.
pub(crate) struct Order<'a> {
    pub(crate) level: u8,
    pub(crate) seed: u64,
    pub(crate) count: usize,
    /// As `dgd-plant conceal --kind` knows them.
    pub(crate) kind: &'a str,
    /// How long each recording lasts, h; by default as the plant draws it.
    pub(crate) hours: Option<f64>,
}

/// Lets the plant make cases below `out`.
pub(crate) fn conceal(plant: &Path, out: &Path, order: &Order<'_>) -> Result<Sealed> {
    let (level, count) = (order.level, order.count);
    let below = |folder: &str| out.join(folder).join(format!("level-{level}"));
    let (cases, truths) = (below("cases"), below("sealed"));
    let output = Command::new(plant)
        .args(["conceal", "--kind", order.kind, "--sealed"])
        .arg("--out")
        .arg(&cases)
        .arg("--truth")
        .arg(&truths)
        .args([
            "--seed",
            &order.seed.to_string(),
            "--count",
            &count.to_string(),
        ])
        .args(["--level", &level.to_string()])
        .args(
            order
                .hours
                .iter()
                .flat_map(|h| ["--hours".to_owned(), h.to_string()]),
        )
        .stderr(Stdio::null())
        .output()
        .with_context(|| format!("cannot run {}", plant.display()))?;
    if !output.status.success() {
        bail!("dgd-plant conceal ended with {}", output.status);
    }
    let sealed = Sealed {
        sha256: String::from_utf8_lossy(&output.stdout).trim().to_owned(),
        ids: (0..count).map(|i| format!("c{i:03}")).collect(),
        level,
        cases,
        truths,
    };
    sealed.check()?;
    Ok(sealed)
}

impl Sealed {
    /// Whether the truths are still those that were sealed.
    ///
    /// # Errors
    /// When they are not.
    pub(crate) fn check(&self) -> Result<()> {
        let mut seal = Sha256::new();
        for id in &self.ids {
            seal.update(self.truth(id)?);
        }
        let found = hex(&seal.finalize());
        if found != self.sha256 {
            bail!(
                "the truths of level {} have the SHA-256 {found}, sealed was {}",
                self.level,
                self.sha256
            );
        }
        Ok(())
    }

    /// The bytes of a truth; only what comes after the last run may look at them.
    pub(crate) fn truth(&self, id: &str) -> Result<Vec<u8>> {
        let path = self.truths.join(format!("{id}.truth.json"));
        std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))
    }
}

/// In hexadecimal.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn a_touched_truth_breaks_the_seal() {
        let folder = tempfile::tempdir().unwrap();
        let write = |id: &str, text: &str| {
            std::fs::write(folder.path().join(format!("{id}.truth.json")), text).unwrap();
        };
        write("c000", "a");
        write("c001", "bc");
        let sealed = Sealed {
            level: 2,
            cases: PathBuf::new(),
            truths: folder.path().to_owned(),
            // Of "abc", the first example of FIPS 180-4.
            sha256: "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad".into(),
            ids: vec!["c000".into(), "c001".into()],
        };
        sealed.check().unwrap();
        write("c001", "bd");
        assert!(sealed.check().unwrap_err().to_string().contains("level 2"));
        std::fs::remove_file(folder.path().join("c001.truth.json")).unwrap();
        assert!(sealed.check().is_err());
    }
}
