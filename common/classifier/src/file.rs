//! The file of a model: a safetensors file, its header naming format, features, training and a checksum of the content.

use crate::ModelError;
use crate::model::{Model, Provenance};
use crate::network::{LAYERS, Layer, Network};
use crate::standard::Standard;
use nalgebra::{DMatrix, DVector};
use railgrip_acoustics::{FEATURE_NAMES, FEATURES, SAMPLE_RATE_HZ};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

/// Version of the form.
pub(crate) const FORMAT: u32 = 1;
/// Key of our header.
const HEADER: &str = "railgrip";

/// A model's file is no longer than this, bytes.
const LARGEST: u64 = 64 << 20;

/// The model that is part of the program: what `railgrip acoustics train` makes without options.
const BUILT_IN: &[u8] = include_bytes!("../models/default.safetensors");

#[derive(Debug, Serialize, Deserialize)]
struct Header {
    format: u32,
    sample_rate_hz: u32,
    features: Vec<String>,
    classes: [String; 2],
    layers: [usize; 4],
    provenance: Provenance,
    sha256: String,
}

/// One array of the file.
struct Array {
    name: String,
    shape: Vec<usize>,
    dtype: Dtype,
    bytes: Vec<u8>,
}

impl Model {
    /// The model that is part of the program.
    ///
    /// # Errors
    /// Never, unless the program is damaged.
    pub fn built_in() -> Result<Self, ModelError> {
        decode("built-in model", BUILT_IN)
    }

    /// Reads a model.
    ///
    /// # Errors
    /// A file that cannot be read, is no model, has another version or is damaged.
    pub fn load(path: &Path) -> Result<Self, ModelError> {
        let mut bytes = Vec::new();
        // A device that was given by mistake never ends.
        std::fs::File::open(path)
            .and_then(|file| file.take(LARGEST).read_to_end(&mut bytes))
            .map_err(|source| ModelError::File { path: path.to_owned(), source })?;
        decode(&path.display().to_string(), &bytes)
    }

    /// Writes the model: beside first, then under its name, so that nobody reads half of it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ModelError> {
        let beside = path.with_extension("new");
        let bytes = encode(self)?;
        std::fs::write(&beside, bytes)
            .and_then(|()| std::fs::rename(&beside, path))
            .map_err(|source| ModelError::File { path: path.to_owned(), source })
    }
}

fn encode(model: &Model) -> Result<Vec<u8>, ModelError> {
    let mut arrays = Vec::new();
    let standard = &model.standard;
    for (name, values) in [
        ("standard.mean", &standard.mean),
        ("standard.sigma", &standard.sigma),
        ("standard.precision", &standard.precision),
        ("standard.familiar", &vec![standard.familiar]),
    ] {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        arrays.push(Array { name: name.to_owned(), shape: vec![values.len()], dtype: Dtype::F32, bytes });
    }
    for (number, Layer { weight, bias }) in model.network.layers.iter().enumerate() {
        // Row by row, as such files have it; nalgebra keeps columns.
        let (rows, columns) = weight.shape();
        arrays.push(half(
            format!("layer{number}.weight"),
            vec![rows, columns],
            weight.transpose().as_slice(),
        ));
        arrays.push(half(format!("layer{number}.bias"), vec![rows], bias.as_slice()));
    }
    arrays.sort_by(|a, b| a.name.cmp(&b.name));
    let header = Header {
        format: FORMAT,
        sample_rate_hz: SAMPLE_RATE_HZ,
        features: FEATURE_NAMES.map(str::to_owned).to_vec(),
        classes: ["dry".to_owned(), "wet".to_owned()],
        layers: LAYERS,
        provenance: model.provenance().clone(),
        sha256: checksum(arrays.iter().map(|array| (array.name.as_str(), array.bytes.as_slice()))),
    };
    let refuse = |problem: String| ModelError::Form { place: "model".to_owned(), problem };
    let text = serde_json::to_string(&header).map_err(|error| refuse(error.to_string()))?;
    let mut views = Vec::new();
    for array in &arrays {
        let view = TensorView::new(array.dtype, array.shape.clone(), &array.bytes)
            .map_err(|error| refuse(error.to_string()))?;
        views.push((array.name.as_str(), view));
    }
    let metadata = HashMap::from([(HEADER.to_owned(), text)]);
    safetensors::serialize(views, Some(metadata)).map_err(|error| refuse(error.to_string()))
}

/// Half precision: eleven bits are plenty for weights, and the file stays small.
fn half(name: String, shape: Vec<usize>, values: &[f32]) -> Array {
    let bytes = values.iter().flat_map(|value| half::f16::from_f32(*value).to_le_bytes()).collect();
    Array { name, shape, dtype: Dtype::F16, bytes }
}

fn decode(place: &str, bytes: &[u8]) -> Result<Model, ModelError> {
    let refuse = |problem: String| ModelError::Form { place: place.to_owned(), problem };
    let (_, metadata) = SafeTensors::read_metadata(bytes)
        .map_err(|error| refuse(format!("no safetensors file ({error})")))?;
    let text = metadata.metadata().as_ref().and_then(|all| all.get(HEADER));
    let text = text.ok_or_else(|| refuse(format!("its header has no entry {HEADER:?}")))?;
    let version: Version = serde_json::from_str(text).map_err(|error| refuse(error.to_string()))?;
    if version.format != FORMAT {
        return Err(refuse(format!("format {}", version.format)));
    }
    let header: Header = serde_json::from_str(text).map_err(|error| refuse(error.to_string()))?;
    let fits = header.layers == LAYERS
        && header.sample_rate_hz == SAMPLE_RATE_HZ
        && header.classes == ["dry", "wet"]
        && header.features == FEATURE_NAMES;
    if !fits {
        return Err(refuse("other features, classes or layers than this program's".to_owned()));
    }
    let tensors = SafeTensors::deserialize(bytes).map_err(|error| refuse(error.to_string()))?;
    let mut names: Vec<&str> = tensors.names();
    names.sort_unstable();
    let mut content = Vec::new();
    for name in &names {
        content.push((*name, tensors.tensor(name).map_err(|error| refuse(error.to_string()))?.data()));
    }
    let found = checksum(content.into_iter());
    if found != header.sha256 {
        return Err(ModelError::Checksum { place: place.to_owned(), found, noted: header.sha256 });
    }
    let vector = |name: &str, length: usize| vector(&tensors, name, length).map_err(refuse);
    let standard = Standard {
        mean: vector("standard.mean", FEATURES)?,
        sigma: vector("standard.sigma", FEATURES)?,
        precision: vector("standard.precision", FEATURES * FEATURES)?,
        familiar: vector("standard.familiar", 1)?[0],
    };
    let mut layers = Vec::new();
    for (number, pair) in LAYERS.windows(2).enumerate() {
        let (inputs, outputs) = (pair[0], pair[1]);
        let weight = vector(&format!("layer{number}.weight"), inputs * outputs)?;
        let bias = vector(&format!("layer{number}.bias"), outputs)?;
        layers.push(Layer {
            weight: DMatrix::from_row_slice(outputs, inputs, &weight),
            bias: DVector::from_vec(bias),
        });
    }
    Ok(Model::of(standard, Network { layers }, header.provenance))
}

#[derive(Deserialize)]
struct Version {
    format: u32,
}

/// Finite numbers of a tensor of that length.
fn vector(tensors: &SafeTensors<'_>, name: &str, length: usize) -> Result<Vec<f32>, String> {
    let view = tensors.tensor(name).map_err(|error| format!("{name}: {error}"))?;
    let values: Vec<f32> = match view.dtype() {
        Dtype::F32 => view.data().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect(),
        Dtype::F16 => {
            let pairs = view.data().as_chunks::<2>().0;
            pairs.iter().map(|bytes| half::f16::from_le_bytes(*bytes).to_f32()).collect()
        }
        other => return Err(format!("{name}: numbers of type {other:?}")),
    };
    if values.len() != length {
        return Err(format!("{name}: {} numbers instead of {length}", values.len()));
    }
    if values.iter().any(|value| !value.is_finite()) {
        return Err(format!("{name}: numbers that are not finite"));
    }
    Ok(values)
}

/// SHA-256 over names and content, in the order of names.
fn checksum<'a>(arrays: impl Iterator<Item = (&'a str, &'a [u8])>) -> String {
    let mut hash = Sha256::new();
    for (name, bytes) in arrays {
        hash.update(name.as_bytes());
        hash.update(bytes);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
