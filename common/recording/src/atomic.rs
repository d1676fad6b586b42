//! Files that appear whole or not at all: written beside their place, then renamed into it.

use crate::error::{Problem, RecordingError, Result};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file under a temporary name; [`AtomicFile::commit`] gives it its own. Dropped before that, it leaves nothing.
#[derive(Debug)]
pub(crate) struct AtomicFile {
    target: PathBuf,
    temporary: PathBuf,
    writer: Option<BufWriter<File>>,
}

impl AtomicFile {
    pub(crate) fn create(target: &Path) -> Result<Self> {
        let name = target.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let temporary = target.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
        let file = File::create(&temporary).map_err(|e| RecordingError::new(target, Problem::Io(e)))?;
        Ok(Self { target: target.to_owned(), temporary, writer: Some(BufWriter::new(file)) })
    }

    pub(crate) fn commit(mut self) -> Result<()> {
        let finish = |writer: Option<BufWriter<File>>| -> std::io::Result<()> {
            if let Some(writer) = writer {
                writer.into_inner().map_err(|e| e.into_error())?.sync_all()?;
            }
            std::fs::rename(&self.temporary, &self.target)
        };
        let writer = self.writer.take();
        finish(writer).map_err(|e| {
            std::fs::remove_file(&self.temporary).ok();
            RecordingError::new(&self.target, Problem::Io(e))
        })
    }

    pub(crate) fn target(&self) -> &Path {
        &self.target
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match &mut self.writer {
            Some(writer) => writer.write(bytes),
            None => Err(std::io::ErrorKind::BrokenPipe.into()),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if self.writer.take().is_some() {
            std::fs::remove_file(&self.temporary).ok();
        }
    }
}
