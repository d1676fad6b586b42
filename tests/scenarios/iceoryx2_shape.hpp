// The shape of those calls of iceoryx2 0.10 for C++ that services/ingest/examples/publish.cpp makes, so that the example can be
// compiled against the generated header where the library is not installed. Nothing here does anything.
#pragma once
#include <cstdint>
#include <string>
#include <type_traits>

namespace iox2 {
template <class T> struct Expected {
    bool has_value() const { return true; }
    T held;
    T value() { return held; }
};
enum class ServiceType { Ipc };
namespace bb {
template <class T> struct Slice {
    using ValueType = T;
};
struct FilePath {
    static Expected<FilePath> create(const char*) { return {}; }
};
struct Duration {
    static Duration from_millis(uint64_t) { return {}; }
};
} // namespace bb
struct Config {
    static Expected<Config> from_file(const bb::FilePath&) { return {}; }
};
struct ServiceName {
    static Expected<ServiceName> create(const char*) { return {}; }
};
template <class T> struct Loan {
    template <class F> Loan write_from_fn(const F& make) {
        static_assert(std::is_same<decltype(make(uint64_t{})), T>::value, "what is made is the payload");
        return *this;
    }
};
template <class T> Expected<int> send(Loan<T>) { return {}; }
template <class T> struct Publisher {
    Expected<Loan<T>> loan_slice_uninit(uint64_t) { return {}; }
};
template <class T> struct PublisherBuilder {
    PublisherBuilder initial_max_slice_len(uint64_t) { return *this; }
    Expected<Publisher<T>> create() { return {}; }
};
template <class T> struct Data {
    static_assert(std::is_trivially_copyable<T>::value && std::is_standard_layout<T>::value, "it lies in shared memory");
    static_assert(T::IOX2_TYPE_NAME != nullptr, "types are told apart by their names");
    PublisherBuilder<T> publisher_builder() { return {}; }
};
template <class S> struct DataBuilder {
    Expected<Data<typename S::ValueType>> open() { return {}; }
};
struct Notifier {
    Expected<int> notify() { return {}; }
};
struct NotifierBuilder {
    Expected<Notifier> create() { return {}; }
};
struct Event {
    NotifierBuilder notifier_builder() { return {}; }
};
struct EventBuilder {
    Expected<Event> open() { return {}; }
};
struct ServiceBuilder {
    template <class S> DataBuilder<S> publish_subscribe() { return {}; }
    EventBuilder event() { return {}; }
};
struct Node {
    ServiceBuilder service_builder(const ServiceName&) { return {}; }
    [[nodiscard]] Expected<int> wait(bb::Duration) { return {}; }
};
struct NodeBuilder {
    NodeBuilder config(const Config&) { return *this; }
    template <ServiceType> Expected<Node> create() { return {}; }
};
} // namespace iox2
