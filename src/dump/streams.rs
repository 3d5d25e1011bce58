//! Streams between a dump and its files, with cancellation and hashing.

use std::io::{self, Read, Write};

use sha2::{Digest, Sha256};

use meliora_base::progress::ProgressSink;

/// A stream that fails as soon as the work is cancelled.
pub(super) struct Watched<'o, T> {
    pub(super) inner: T,
    pub(super) sink: &'o dyn ProgressSink,
}

impl<T> Watched<'_, T> {
    fn go_on(&self) -> io::Result<()> {
        if self.sink.stop().is_some() { Err(io::Error::other("stopped")) } else { Ok(()) }
    }
}

impl<W: Write> Write for Watched<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.go_on()?;
        self.inner.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<R: Read> Read for Watched<'_, R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.go_on()?;
        self.inner.read(bytes)
    }
}

/// A stream that hashes the bytes that pass through.
pub(super) struct Hashing<T> {
    pub(super) inner: T,
    pub(super) hash: Sha256,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(bytes)?;
        self.hash.update(&bytes[..read]);
        Ok(read)
    }
}
