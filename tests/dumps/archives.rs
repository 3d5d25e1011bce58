//! Archives that are damaged or hostile are refused, and are never read as another model.

use std::io::{Read, Write};
use std::sync::atomic::{AtomicUsize, Ordering};

use flate2::Compression;
use flate2::write::GzEncoder;
use meliora::progress::ProgressSink;
use tar::{Builder, EntryType, Header};

use crate::common::prelude::*;
use crate::dumps::exchange::{index, none, read, tar, words};

/// The archive of two states, compressed by xz.
const XZ: &[u8] = include_bytes!("two_states.umb");

fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("index.json", index("", "").into_bytes()),
        ("state-is-initial.bin", words(&[1])),
        ("branch-to-target.bin", words(&[1, 1])),
    ]
}

/// The archive of two states, not compressed.
fn plain() -> Vec<u8> {
    let files = files();
    tar(&files.iter().map(|(name, content)| (*name, content.as_slice())).collect::<Vec<_>>())
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// The model as text.
fn shown(checked: Checked) -> String {
    meliora::lang::flat(&checked.program).unwrap()
}

/// The message of an archive that must be refused.
#[track_caller]
fn refused(bytes: &[u8]) -> String {
    match read(bytes) {
        Err(Error::Io { message, .. }) => message,
        other => panic!("{:?}", other.map(shown)),
    }
}

#[test]
fn an_archive_that_is_cut_anywhere_is_refused() {
    for whole in [plain(), gzip(&plain()), XZ.to_vec()] {
        assert!(read(&whole).is_ok());
        let read = (0..whole.len()).find(|&cut| read(&whole[..cut]).is_ok());
        assert_eq!(read, None, "of {} bytes", whole.len());
    }
}

#[test]
fn a_compressed_archive_with_a_wrong_bit_is_refused_or_the_same_model() {
    for whole in [gzip(&plain()), XZ.to_vec()] {
        let model = shown(read(&whole).unwrap());
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 1 << (at % 8);
            if let Ok(found) = read(&damaged) {
                assert_eq!(shown(found), model, "byte {at}");
            }
        }
    }
}

#[test]
fn a_wrong_checksum_of_gzip_is_refused() {
    let whole = gzip(&plain());
    for at in whole.len() - 8..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 1;
        assert!(refused(&damaged).contains("corrupt gzip stream"), "byte {at}");
    }
}

#[test]
fn the_end_of_an_archive_is_its_end() {
    let plain = plain();
    // Programs fill up the last record with zeros.
    assert!(read(&[&plain[..], &[0; 4096]].concat()).is_ok());
    assert!(refused(&[&plain[..], &plain].concat()).contains("data after its end"));
    assert!(refused(&plain[..plain.len() - 512]).contains("its end is missing"));
    assert!(refused(&plain[..plain.len() - 1024]).contains("its end is missing"));
    refused(&[&gzip(&plain)[..], b"more"].concat());
    refused(&[XZ, b"more"].concat());
    // One archive may be compressed in several pieces.
    let (left, right) = plain.split_at(700);
    assert!(read(&[gzip(left), gzip(right)].concat()).is_ok());
    assert!(read(&[XZ, &[0; 8]].concat()).is_ok());
}

/// The archive with one more entry in front, of some type.
fn with_entry(ty: EntryType, size: u64, content: &mut dyn Read) -> Vec<u8> {
    let mut builder = Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
    let mut header = Header::new_gnu();
    header.set_entry_type(ty);
    header.set_path("more").unwrap();
    header.set_size(size);
    header.set_cksum();
    builder.append(&header, content).unwrap();
    let mut encoder = builder.into_inner().unwrap();
    encoder.flush().unwrap();
    let more = encoder.finish().unwrap();
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(&more[..]).read_to_end(&mut bytes).unwrap();
    [&bytes[..bytes.len() - 1024], &plain()].concat()
}

#[test]
fn a_size_that_lies_is_damage_and_no_limit() {
    let lies = with_entry(EntryType::Regular, 1 << 33, &mut std::io::empty());
    assert!(refused(&lies).contains("it ends within more"));
}

#[test]
fn links_and_sparse_files_are_refused_because_the_model_would_lack_them() {
    assert!(read(&with_entry(EntryType::Directory, 0, &mut std::io::empty())).is_ok());
    for ty in [EntryType::Symlink, EntryType::Link, EntryType::Fifo, EntryType::XGlobalHeader] {
        let found = refused(&with_entry(ty, 0, &mut std::io::empty()));
        assert!(found.contains("more: only plain files and folders"), "{ty:?}: {found}");
    }
    let mut builder = Builder::new(Vec::new());
    builder.append_pax_extensions([("GNU.sparse.major", &b"1"[..])]).unwrap();
    let mut header = Header::new_ustar();
    header.set_size(1);
    builder.append_data(&mut header, "index.json", &b"{"[..]).unwrap();
    assert!(refused(&builder.into_inner().unwrap()).contains("only plain files and folders"));
}

#[test]
fn a_path_of_a_megabyte_is_refused_and_not_shown() {
    let long = with_entry(EntryType::GNULongName, 1 << 20, &mut std::io::repeat(b'x').take(1 << 20));
    let found = refused(&long);
    assert!(found.contains("a path has 1048576 bytes"), "{found:.100}");
}

/// Stops the work after some queries.
struct Patience(AtomicUsize);

impl ProgressSink for Patience {
    fn stop(&self) -> Option<Limit> {
        let left = self.0.fetch_sub(1, Ordering::Relaxed);
        (left == 0).then_some(Limit::Interrupted)
    }
}

#[test]
fn names_and_extensions_that_never_end_can_be_stopped() {
    for ty in [EntryType::GNULongName, EntryType::GNULongLink, EntryType::XHeader] {
        let long = gzip(&with_entry(ty, 20 << 20, &mut std::io::repeat(b'x').take(20 << 20)));
        let found = Document::read("m.umb", &long[..]).unwrap().load(&none(), &Patience(12.into()));
        assert!(matches!(found, Err(Error::Limit(Limit::Interrupted))), "{ty:?}");
    }
}
