#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/model/network.hpp>
#include <tilemesh/model/parameter_file.hpp>
#include <vector>

// The lines of a network in a file of parameters (model/parameter_file.hpp). A file has `network` and `network.nodes`, or none of them:
//   network                 mesh | torus      kind           the network's name
//   network.nodes           10x12             nodes          source
//   network.memory_columns  0,5               columns        source
//   network.link            32, or 32/3: bytes in so many cycles    bytes_a_cycle    source;   also port_in, port_out, memory, border
//   network.flit            32                bytes          source; also packet, head
//   network.hop             9                 cycles         source; also latency, issue, crossing
//   network.outstanding     6                 transfers      source
//   network.chip            4x4               nodes          source
// A line that is left out stands for 0: it bounds nothing, or takes no time.
namespace tilemesh { inline namespace v0_2 { namespace model_detail {

/// A name that only a network's line may have.
TILEMESH_HOST bool is_network_name(std::string_view name) noexcept;
/// The rules of all lines; each is optional.
TILEMESH_HOST std::vector<ParameterRule> network_rules();
/// The lines of a network. Throws `Error` for a number without a source that a file can hold, and for a name that is not one line.
TILEMESH_HOST std::string network_lines(Network const& network);

/// A whole number from `least` to `most`; nothing for any other text.
TILEMESH_HOST std::optional<std::uint64_t> number_within(std::string_view text, std::uint64_t least, std::uint64_t most);
/// The rows of a table: name, value, unit, source of each line that a file would have, but for the network's name.
TILEMESH_HOST std::vector<std::vector<std::string>> network_rows(Network const& network);

/// "32" or "32/3", whole numbers from 0 to `most` and from 1 to 10^8; nothing for any other text.
TILEMESH_HOST std::optional<NetworkNumber> rate_of(std::string_view text, std::uint64_t most);
TILEMESH_HOST std::string rate_text(std::uint64_t value, std::uint64_t per);

/// Reads the lines of a network, in any order.
class NetworkReader {
public:
    using Refuse = std::function<void(std::string const& problem, std::string const& why, std::string const& todo)>;
    /// The value of a line that is not one whole number; nothing if it is one. `name` is a network's.
    TILEMESH_HOST std::optional<std::uint64_t> word(std::string_view name, std::string_view text, Refuse const& refuse);
    TILEMESH_HOST void set(ModelParameter const& p);
    /// The network of all lines; nothing if there was none. `file_name` begins the error for a network without its name or its nodes.
    TILEMESH_HOST std::optional<Network> take(std::string const& file_name) const;

private:
    Network network_;
    std::uint64_t per_ = 1;
    bool named_ = false, sized_ = false, any_ = false;
};

}}} // namespace tilemesh::model_detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/model/detail/network_lines_code.hpp>
#endif
