//! What can go wrong on the bus, in words for whoever runs the train.

use std::path::PathBuf;

/// Why a bus operation failed.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// Socket paths have little room.
    #[error(
        "channel prefix {prefix} is too long: in the path of a socket it makes {length} characters, \
         at most {max} fit; choose a shorter one"
    )]
    PrefixTooLong {
        /// The prefix.
        prefix: String,
        /// Characters of root and prefix.
        length: usize,
        /// Characters that fit.
        max: usize,
    },
    /// A limit or a wagon number makes no sense.
    #[error("{what} = {value}: allowed is {allowed}")]
    Limit {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: u64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A file of the instance could not be used.
    #[error("{path}: {source}")]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The folder of the instance is somebody else's.
    #[error(
        "{folder} belongs to user {owner} and this is user {user}: whoever owns it knows the keys in it; give another folder \
         ([instance] dir, --instance), or remove this one"
    )]
    ForeignFolder {
        /// The folder.
        folder: PathBuf,
        /// Id of its owner.
        owner: u32,
        /// Id of this process's user.
        user: u32,
    },
    /// Another holder has this train.
    #[error("train \"{train}\" is already running on this machine (holder process {pid}, folder {folder})")]
    AlreadyHeld {
        /// The train.
        train: String,
        /// The process id of its holder, or "?".
        pid: String,
        /// The folder of the instance.
        folder: PathBuf,
    },
    /// Another running train has this prefix, and each would remove the other's channels.
    #[error(
        "the prefix \"{prefix}\" belongs to another running train; give train \"{train}\" another [instance] prefix, or none: \
         the default follows from its folder"
    )]
    PrefixTaken {
        /// The train.
        train: String,
        /// The prefix.
        prefix: String,
    },
    /// The channels do not fit into the shared memory.
    #[error(
        "{folder} has {free_mb} MB left and the channels of train \"{train}\" take up to {needed_mb} MB: make it larger \
         (mount option size=, docker run --shm-size) or free some of it"
    )]
    SharedMemoryFull {
        /// The train.
        train: String,
        /// Where shared memory lives.
        folder: &'static str,
        /// What is left, MB.
        free_mb: u64,
        /// What the channels take at most, MB.
        needed_mb: u64,
    },
    /// A process of this kind, for this wagon, runs already.
    #[error(
        "train \"{train}\" has {role} already (it keeps {file}); two of them would contradict each other"
    )]
    RoleTaken {
        /// The train.
        train: String,
        /// The process, and the wagon it serves.
        role: String,
        /// The file that it has locked.
        file: PathBuf,
    },
    /// Nobody holds this train.
    #[error(
        "train \"{train}\" has no holder on this machine (folder {folder}); start it with `railgrip up` or `railgrip hold`"
    )]
    NoHolder {
        /// The train.
        train: String,
        /// The folder of the instance.
        folder: PathBuf,
    },
    /// The holder that created our channels is gone; whoever holds now has others.
    #[error("the holder of train \"{train}\" is gone; this process must start anew")]
    HolderGone {
        /// The train.
        train: String,
    },
    /// Channels are gone although their holder lives.
    #[error("{missing} of the {channels} channels of train \"{train}\" are gone; they must be created anew")]
    ChannelsGone {
        /// The train.
        train: String,
        /// How many are gone.
        missing: usize,
        /// How many there were.
        channels: usize,
    },
    /// This process already uses another instance; iceoryx2 allows one configuration a process.
    #[error("this process is bound to the instance in {bound} and cannot use {wanted}")]
    OtherInstance {
        /// The configuration in use.
        bound: PathBuf,
        /// The one asked for.
        wanted: PathBuf,
    },
    /// The holder created this channel with another payload.
    #[error(
        "channel {channel}: this program speaks {ours}, the running train speaks {theirs}; use programs of one version"
    )]
    Version {
        /// The channel.
        channel: String,
        /// Our payload.
        ours: String,
        /// Their payload.
        theirs: String,
    },
    /// The holder did not create this channel, for example for a wagon that the train does not have.
    #[error("channel {channel} does not exist in train \"{train}\"")]
    NoChannel {
        /// The channel.
        channel: String,
        /// The train.
        train: String,
    },
    /// All places of a channel are taken, and none came free.
    #[error("channel {channel}: every place for a {port} is taken")]
    NoPlace {
        /// The channel.
        channel: String,
        /// Publisher or subscriber.
        port: &'static str,
    },
    /// iceoryx2 refused.
    #[error("channel {channel}: cannot {action} ({reason})")]
    Transport {
        /// The channel.
        channel: String,
        /// What was tried.
        action: &'static str,
        /// What iceoryx2 says.
        reason: String,
    },
    /// The node of this process could not be created.
    #[error("cannot join train \"{train}\" in {folder} ({reason}); all its processes must run as one user")]
    Node {
        /// The train.
        train: String,
        /// The folder of the instance.
        folder: PathBuf,
        /// What iceoryx2 says.
        reason: String,
    },
}

impl BusError {
    pub(crate) fn transport(channel: &str, action: &'static str, reason: impl std::fmt::Debug) -> Self {
        Self::Transport { channel: channel.to_owned(), action, reason: format!("{reason:?}") }
    }
}
