//! The shared memory of one train: whose files are whose, and whether there is room for them.

use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener};
use std::path::Path;
use std::time::{Duration, Instant};

use crate::config::SHARED_MEMORY;
use crate::{BusConfig, BusError, CHANNELS, Channel, Limits, Scope};

/// iceoryx2 puts a checksum of so many hexadecimal digits behind the prefix.
const CHECKSUM_DIGITS: usize = 40;
/// What connections and the administration of channels take beside their data, as a share of it.
const ADMINISTRATION: f64 = 0.1;
const POLL: Duration = Duration::from_millis(20);

/// The right to use a prefix, held until dropped: a socket without a file, which the kernel releases at any death.
#[derive(Debug)]
pub(crate) struct PrefixClaim {
    _socket: UnixListener,
}

impl PrefixClaim {
    /// Tries until `patience` is over.
    ///
    /// # Errors
    /// [`BusError::PrefixTaken`] if another process has it.
    pub(crate) fn take(config: &BusConfig, patience: Duration) -> Result<Self, BusError> {
        let name = format!("railgrip/{}", config.prefix);
        let failed = |source| BusError::File { path: format!("@{name}").into(), source };
        let address = SocketAddr::from_abstract_name(&name).map_err(failed)?;
        let deadline = Instant::now() + patience;
        loop {
            match UnixListener::bind_addr(&address) {
                Ok(_socket) => return Ok(Self { _socket }),
                Err(error) if error.kind() != std::io::ErrorKind::AddrInUse => return Err(failed(error)),
                Err(_) if Instant::now() < deadline => std::thread::sleep(POLL),
                Err(_) => {
                    let (train, prefix) = (config.train.clone(), config.prefix.clone());
                    return Err(BusError::PrefixTaken { train, prefix });
                }
            }
        }
    }
}

/// Removes the files of a prefix, and of no other that merely begins with the same letters.
pub(crate) fn wipe(prefix: &str) -> Result<(), BusError> {
    let folder = Path::new(SHARED_MEMORY);
    let entries =
        std::fs::read_dir(folder).map_err(|source| BusError::File { path: folder.to_owned(), source })?;
    for entry in entries.flatten() {
        if entry.file_name().to_str().is_some_and(|name| is_of(prefix, name)) {
            remove_file(&entry.path())?;
        }
    }
    Ok(())
}

/// Removes a file that may be gone already.
pub(crate) fn remove_file(path: &Path) -> Result<(), BusError> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(BusError::File { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}

/// True for what iceoryx2 names under a prefix: the prefix, a checksum, `_` and more.
fn is_of(prefix: &str, name: &str) -> bool {
    let Some((checksum, rest)) =
        name.strip_prefix(prefix).and_then(|rest| rest.split_at_checked(CHECKSUM_DIGITS))
    else {
        return false;
    };
    checksum.bytes().all(|digit| digit.is_ascii_hexdigit()) && rest.starts_with('_')
}

/// Fails unless everything that the channels can take fits: a page of shared memory that is not there kills whoever
/// writes to it, without a word.
pub(crate) fn check_room(config: &BusConfig) -> Result<(), BusError> {
    let free = rustix::fs::statvfs(SHARED_MEMORY)
        .map_err(|error| BusError::File { path: SHARED_MEMORY.into(), source: error.into() })?;
    let (free, needed) = (free.f_bavail.saturating_mul(free.f_frsize), needed_bytes(config));
    if free >= needed {
        return Ok(());
    }
    let megabytes = |bytes: u64| bytes.div_ceil(1_000_000);
    Err(BusError::SharedMemoryFull {
        train: config.train.clone(),
        folder: SHARED_MEMORY,
        free_mb: free / 1_000_000,
        needed_mb: megabytes(needed),
    })
}

/// What all channels take when each has the publisher that it is meant for and every slot was used once, bytes.
pub(crate) fn needed_bytes(config: &BusConfig) -> u64 {
    let limits = &config.limits;
    let of = |scope: Scope| CHANNELS.iter().filter(move |row| row.scope == scope);
    // A wagon has one kind of samples: the largest stands for all.
    let (inlets, outlets): (Vec<_>, Vec<_>) = of(Scope::Wagon).partition(|row| row.wakes);
    let sum = |rows: Vec<&Channel>| rows.into_iter().map(|row| publisher_bytes(row, limits)).sum::<u64>();
    let inlet = inlets.into_iter().map(|row| publisher_bytes(row, limits)).max().unwrap_or(0);
    let wagon = inlet + sum(outlets);
    let (wagons, microphones) = (config.wagons.len() as u64, config.microphones.len() as u64);
    // Every process of the train publishes on its channels; one serves the pages, one brings the samples.
    let (alone, shared): (Vec<_>, Vec<_>) = of(Scope::Train).partition(|row| row.alone);
    let train = sum(alone) + sum(shared) * (wagons + microphones + 2);
    let data = wagons * wagon + microphones * sum(of(Scope::Microphone).collect()) + train;
    data + (data as f64 * ADMINISTRATION) as u64
}

/// The data of one publisher: what every reader may have before it, what late joiners get, and what is being written.
fn publisher_bytes(row: &Channel, limits: &Limits) -> u64 {
    let (buffer, items) = row.capacity(limits);
    let slots = limits.subscribers * (buffer + 1) + row.history + 1;
    (slots * items * row.item_bytes) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(prefix: &str, wagons: u32) -> BusConfig {
        BusConfig {
            train: "demo".into(),
            dir: "/tmp/demo".into(),
            prefix: prefix.into(),
            wagons: (1..=wagons).collect(),
            microphones: Vec::new(),
            limits: Limits::default(),
        }
    }

    #[test]
    fn a_prefix_owns_its_files_and_no_others() {
        let checksum = "0354a209029e7d094a819e2d4030ea331e6caaf0";
        let name = |prefix: &str| format!("{prefix}{checksum}_237684812133113.data");
        for prefix in ["r", "rg0fda0315_", "a"] {
            assert!(is_of(prefix, &name(prefix)), "{prefix}");
        }
        // The letters of a longer prefix may look like digits of the checksum.
        for (prefix, other) in [("r", "rg_"), ("a", "ab"), ("rg_", "rg_2_"), ("s", "sem.")] {
            assert!(!is_of(prefix, &name(other)), "{prefix} {other}");
        }
        assert!(!is_of("p", "pulse-shm-1234") && !is_of("p", "p"));
    }

    #[test]
    fn a_prefix_has_one_owner_at_a_time() {
        let config = config(&format!("one{}_", std::process::id()), 1);
        let first = PrefixClaim::take(&config, Duration::ZERO).expect("free");
        let said = PrefixClaim::take(&config, Duration::from_millis(30)).expect_err("taken").to_string();
        assert!(said.contains("another running train") && said.contains("prefix"), "{said}");
        drop(first);
        PrefixClaim::take(&config, Duration::ZERO).expect("free again");
    }

    #[test]
    fn what_is_needed_grows_with_the_train_and_too_little_is_said_in_megabytes() {
        let [one, eight] = [1, 8].map(|wagons| needed_bytes(&config("x", wagons)));
        // 8 wagons were seen to take 111 MB.
        assert!((90_000_000..160_000_000).contains(&eight), "{eight}");
        assert!(one < eight / 4, "{one} {eight}");
        let mut huge = config("x", 200);
        huge.limits = Limits { max_batch: 4096, buffer: 4096, ..Limits::default() };
        let said = check_room(&huge).expect_err("terabytes").to_string();
        assert!(said.contains("/dev/shm has") && said.contains("--shm-size"), "{said}");
    }
}
