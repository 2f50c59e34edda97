#pragma once
#include <stdexcept>

namespace tilemesh { inline namespace v0_2 {

/// A bad file, option or machine, or a broken promise in a kernel. The text is one line: "<problem> (<why>); <what to do>".
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}} // namespace tilemesh
