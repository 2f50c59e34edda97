# shellcheck shell=sh disable=SC2034
# What kernel code may include of the libraries, as extended regular expressions: what a codelet compiler is known to have, and GLM's
# small headers (glm/glm.hpp needs <cfloat>, which it has not).
standard_headers='array|cmath|cstddef|cstdint|cstring|initializer_list|limits|type_traits|utility|algorithm|tuple'
glm_headers='glm/(vec2|vec3|vec4|mat2x2|mat3x3|mat4x4)\.hpp'
