//! WAV files: what a microphone recorded, as samples with full scale ±1.

use hound::{SampleFormat, WavReader, WavSpec, WavWriter};
use std::path::{Path, PathBuf};

/// A recording of one microphone.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Samples a second.
    pub sample_rate_hz: u32,
    /// Samples, full scale ±1; those of the first channel if there are several.
    pub samples: Vec<f32>,
    /// Channels in the file.
    pub channels: u16,
}

/// A WAV file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WavError {
    /// Not readable as WAV.
    #[error("{}: {source}; allowed is a WAV file of 8 to 32 bit integers or 32 bit floats", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: hound::Error,
    },
    /// Not writable.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: hound::Error,
    },
    /// A rate at which nothing is sampled.
    #[error("{}: its header says 0 samples a second", path.display())]
    Rate {
        /// The file.
        path: PathBuf,
    },
    /// Without samples.
    #[error("{}: no samples", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
}

/// Reads a WAV file.
///
/// # Errors
/// A file that is no WAV file, is cut off or is empty.
pub fn read(path: &Path) -> Result<Recording, WavError> {
    let failed = |source| WavError::Read { path: path.to_owned(), source };
    let mut reader = WavReader::open(path).map_err(failed)?;
    let WavSpec { channels, sample_rate, bits_per_sample, sample_format } = reader.spec();
    if sample_rate == 0 {
        return Err(WavError::Rate { path: path.to_owned() });
    }
    let every = usize::from(channels.max(1));
    let samples: Result<Vec<f32>, _> = match sample_format {
        SampleFormat::Float => reader.samples::<f32>().step_by(every).collect(),
        SampleFormat::Int => {
            let scale = 1.0 / (1_i64 << (bits_per_sample.clamp(1, 32) - 1)) as f32;
            reader.samples::<i32>().step_by(every).map(|sample| Ok(sample? as f32 * scale)).collect()
        }
    };
    let samples = samples.map_err(failed)?;
    if samples.is_empty() {
        return Err(WavError::Empty { path: path.to_owned() });
    }
    Ok(Recording { sample_rate_hz: sample_rate, samples, channels })
}

/// Writes samples as a mono WAV file of 16 bit; what is beyond full scale is cut.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, sample_rate_hz: u32, samples: &[f32]) -> Result<(), WavError> {
    let failed = |source| WavError::Write { path: path.to_owned(), source };
    let spec = WavSpec {
        channels: 1,
        sample_rate: sample_rate_hz,
        bits_per_sample: 16,
        sample_format: SampleFormat::Int,
    };
    let mut writer = WavWriter::create(path, spec).map_err(failed)?;
    for sample in samples {
        let value = (f64::from(*sample) * 32_768.0).round().clamp(-32_768.0, 32_767.0);
        writer.write_sample(value as i16).map_err(failed)?;
    }
    writer.finalize().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_of_zero_is_refused() {
        let path = std::env::temp_dir().join(format!("railgrip-wav-rate-{}.wav", std::process::id()));
        write(&path, 22_050, &[0.1; 100]).expect("written");
        let mut bytes = std::fs::read(&path).expect("read");
        // The rate and, by it, bytes a second.
        bytes[24..32].fill(0);
        std::fs::write(&path, bytes).expect("written");
        let error = read(&path).expect_err("no rate");
        std::fs::remove_file(&path).expect("removed");
        assert!(matches!(error, WavError::Rate { .. }), "{error}");
    }

    #[test]
    fn what_was_written_is_read() {
        let path = std::env::temp_dir().join(format!("railgrip-wav-{}.wav", std::process::id()));
        let samples: Vec<f32> = (0..1000).map(|n| (n as f32 - 500.0) / 512.0).collect();
        write(&path, 22_050, &samples).expect("written");
        let found = read(&path).expect("read");
        std::fs::write(&path, b"no wav").expect("written");
        let error = read(&path).expect_err("no WAV file");
        std::fs::remove_file(&path).expect("removed");
        assert_eq!((found.sample_rate_hz, found.channels), (22_050, 1));
        assert!(found.samples.iter().zip(&samples).all(|(a, b)| (a - b).abs() < 1.0 / 32_768.0));
        assert!(error.to_string().contains("railgrip-wav-") && error.to_string().contains("WAV"), "{error}");
    }
}
