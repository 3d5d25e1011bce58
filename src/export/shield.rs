//! Shields in a directory: the table, and a manifest with its hash.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use meliora_base::error::{Error, Result, ensure};
use meliora_base::files::folder;
use meliora_base::json;
use meliora_base::reading::{self, regular};
use meliora_dump::directory::sha256;
use meliora_dump::place::{Place, Sort};
use meliora_planning::Shield;

const MANIFEST: &str = "shield.json";
const NODES: &str = "nodes.json";
const FORMAT: &str = "meliora shield 1";

/// The directory of a shield.
const SHIELD: Sort = Sort {
    name: "shield",
    files: |directory| {
        let manifest: Manifest = serde_json::from_slice(&read(directory, MANIFEST).ok()?).ok()?;
        let is_own = |name: &&str| {
            *name == MANIFEST || read(directory, name).is_ok_and(|nodes| sha256(&nodes) == manifest.sha256)
        };
        let own = [MANIFEST, NODES].into_iter().filter(is_own).map(str::to_owned).collect();
        (manifest.format == FORMAT).then_some(own)
    },
};

/// The manifest of a shield.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    format: String,
    /// The SHA-256 of the table.
    sha256: String,
    nodes: usize,
}

/// Writes a shield into a directory, which is created if it does not exist. An older shield in it is
/// replaced.
///
/// # Errors
/// The directory contains something else than a shield, or cannot be written.
pub fn write_shield(shield: &Shield, directory: &Path) -> Result<()> {
    let failed = |e| Error::writing(directory, &e);
    fs::create_dir_all(folder(directory)).map_err(failed)?;
    let place = Place::find(directory, SHIELD)?;
    let text = |found: serde_json::Result<String>| found.map_err(|e| Error::writing(directory, &e.into()));
    let nodes = text(json::compact(shield))?;
    let manifest =
        Manifest { format: FORMAT.to_owned(), sha256: sha256(nodes.as_bytes()), nodes: shield.nodes.len() };
    let manifest = text(json::pretty(&manifest))?;
    let new = place.temporary().map_err(failed)?;
    new.write(NODES, nodes.as_bytes()).map_err(failed)?;
    new.write(MANIFEST, (manifest + "\n").as_bytes()).map_err(failed)?;
    place.install(new)
}

fn read(directory: &Path, name: &str) -> Result<Vec<u8>> {
    let path = directory.join(name);
    let file = regular(&path).map_err(|e| Error::reading(&path, &e))?;
    reading::bytes(&path.display().to_string(), file)
}

/// Reads a shield, and checks its hash, its numbers and its promise: see [`Shield::fault`].
///
/// # Errors
/// A file cannot be read, is malformed, or has changed; the promise does not follow from the table.
pub fn read_shield(directory: &Path) -> Result<Shield> {
    let wrong = |name: &str, message: String| {
        let file = directory.join(name).display().to_string();
        Error::Dump { file, line: 0, message }
    };
    let manifest: Manifest =
        serde_json::from_slice(&read(directory, MANIFEST)?).map_err(|e| wrong(MANIFEST, e.to_string()))?;
    ensure(manifest.format == FORMAT, || {
        wrong(MANIFEST, format!("the format is `{}`, not `{FORMAT}`", manifest.format.escape_debug()))
    })?;
    let nodes = read(directory, NODES)?;
    let found = sha256(&nodes);
    ensure(found == manifest.sha256, || {
        let said = &manifest.sha256;
        wrong(NODES, format!("the file has changed: its SHA-256 is {found}, the manifest says {said}"))
    })?;
    let shield: Shield = serde_json::from_slice(&nodes).map_err(|e| wrong(NODES, e.to_string()))?;
    match shield.fault() {
        _ if shield.nodes.len() != manifest.nodes => {
            Err(wrong(NODES, format!("{} nodes, the manifest says {}", shield.nodes.len(), manifest.nodes)))
        }
        Some(fault) => Err(wrong(NODES, fault)),
        None => Ok(shield),
    }
}
