//! The unpacked bytes of an archive, up to the limits of the work.

use std::io::{self, Read};

use flate2::read::MultiGzDecoder;
use lzma_rust2::XzReader;

use meliora_base::error::{Error, Limit};
use meliora_base::progress::ProgressSink;

/// Maximum size of the dictionary of xz, in KiB; the strongest usual setting takes 64 MiB.
const MOST_DICTIONARY: u32 = (80 << 20) >> 10;

const GZIP: &[u8] = &[0x1f, 0x8b, 0x08];
const XZ: &[u8] = &[0xfd, b'7', b'z', b'X', b'Z', 0];

/// A stream of unpacked bytes. It fails with an [`Error`] inside of the error when a limit is
/// reached, whatever the reader of the stream does with the bytes.
pub(super) struct Unpacked<'a> {
    name: &'a str,
    stream: Box<dyn Read + 'a>,
    /// The number of bytes so far, and the maximum.
    bytes: u64,
    most: u64,
    sink: &'a dyn ProgressSink,
}

impl<'a> Unpacked<'a> {
    /// Returns whether some bytes are compressed, by their first bytes.
    pub(super) fn is_compressed(bytes: &[u8]) -> bool {
        bytes.starts_with(GZIP) || bytes.starts_with(XZ)
    }

    /// Starts to unpack at most `most` bytes; `name` is the path of the archive in messages.
    pub(super) fn new(name: &'a str, bytes: &'a [u8], most: u64, sink: &'a dyn ProgressSink) -> Self {
        let stream: Box<dyn Read + '_> = match bytes {
            _ if bytes.starts_with(GZIP) => Box::new(MultiGzDecoder::new(bytes)),
            _ if bytes.starts_with(XZ) => Box::new(XzReader::new_mem_limit(bytes, true, MOST_DICTIONARY)),
            _ => Box::new(bytes),
        };
        Unpacked { name, stream, bytes: 0, most, sink }
    }

    /// Reads the rest of the stream, which ends with the checksums. Returns the number of bytes if
    /// all are zero.
    pub(super) fn zeros(mut self) -> io::Result<Option<u64>> {
        let (mut buffer, mut all, mut is_zero) = ([0; 1 << 12], 0, true);
        loop {
            let read = self.read(&mut buffer)?;
            if read == 0 {
                return Ok(is_zero.then_some(all));
            }
            all += read as u64;
            is_zero &= buffer[..read].iter().all(|byte| *byte == 0);
        }
    }

    fn limited<T>(&self, limit: Limit) -> io::Result<T> {
        Err(io::Error::other(Error::from(limit)))
    }
}

impl Read for Unpacked<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if let Some(limit) = self.sink.stop() {
            return self.limited(limit);
        }
        let read = match self.stream.read(into) {
            Err(e) if e.kind() == io::ErrorKind::OutOfMemory => {
                let most = MOST_DICTIONARY >> 10;
                let what = format!("{} is compressed with a dictionary of more than {most} MiB", self.name);
                return self.limited(Limit::Size { what });
            }
            read => read?,
        };
        self.bytes += read as u64;
        if self.bytes > self.most {
            let what = format!("{} unpacks to more than {} MiB", self.name, self.most >> 20);
            return self.limited(Limit::Size { what });
        }
        Ok(read)
    }
}
