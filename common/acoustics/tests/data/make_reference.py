"""Computes the reference features of features.rs with librosa itself (0.11) and writes librosa_features.json.

The signals are defined by integer arithmetic and sines so that Rust makes exactly the same ones:
run `python make_reference.py` in this folder after `pip install librosa==0.11.0`.
"""

import json

import librosa
import numpy as np

RATE = 22050


def noise(seed, count):
    """Uniform noise in -1..1 from a 32-bit linear congruential generator."""
    state, values = seed, np.empty(count)
    for index in range(count):
        state = (1664525 * state + 1013904223) % 2**32
        values[index] = state / 2**31 - 1.0
    return values


def signals():
    time = np.arange(RATE) / RATE
    smooth = np.convolve(noise(7, RATE + 31), np.ones(32) / 32, mode="valid")
    yield "white noise", 0.3 * noise(1, RATE)
    yield "two tones", 0.4 * np.sin(2 * np.pi * 443.0 * time) + 0.2 * np.sin(2 * np.pi * 1337.0 * time)
    yield "rumble and squeal", smooth + 0.05 * np.sin(2 * np.pi * 2750.0 * time)
    yield "swept tone", 0.5 * np.sin(2 * np.pi * (200.0 * time + 900.0 * time**2)) + 0.01 * noise(3, RATE)


def features(audio):
    audio = audio.astype(np.float32)
    values = [
        librosa.feature.zero_crossing_rate(audio).mean(),
        librosa.feature.spectral_centroid(y=audio, sr=RATE).mean(),
        librosa.feature.spectral_rolloff(y=audio, sr=RATE).mean(),
        *librosa.feature.mfcc(y=audio, sr=RATE, n_mfcc=20).mean(axis=1),
        librosa.feature.chroma_stft(y=audio, sr=RATE).mean(),
        librosa.feature.spectral_bandwidth(y=audio, sr=RATE).mean(),
        librosa.feature.rms(y=audio).mean(),
    ]
    return [float(value) for value in values]


with open("librosa_features.json", "w") as file:
    json.dump({name: features(audio) for name, audio in signals()}, file, indent=1)
