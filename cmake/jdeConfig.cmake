# Schemas in C and C++. find_package(jde) gives the target jde::jde, which has the headers, and the functions below.
#
# This file belongs to PREFIX/lib/cmake/jde of an installation, whose headers are in PREFIX/include, or to the folder cmake
# of a checkout. CMAKE_PREFIX_PATH is PREFIX, or the checkout.

foreach(prefix ${CMAKE_CURRENT_LIST_DIR}/.. ${CMAKE_CURRENT_LIST_DIR}/../../..)
    if(EXISTS ${prefix}/include/jde.h AND NOT TARGET jde::jde)
        add_library(jde::jde INTERFACE IMPORTED)
        get_filename_component(JDE_INCLUDE_DIR ${prefix}/include ABSOLUTE)
        set_target_properties(jde::jde PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${JDE_INCLUDE_DIR} INTERFACE_LINK_LIBRARIES m)
    endif()
endforeach()
if(NOT TARGET jde::jde)
    set(jde_FOUND FALSE)
    set(jde_NOT_FOUND_MESSAGE "the headers of jde are neither in ../include nor in ../../../include of this file")
endif()

# Builds the plugin NAME from its sources: lib<NAME>.so, with `-` written `_`.
function(jde_add_plugin NAME)
    string(REPLACE "-" "_" file ${NAME})
    add_library(plugin_${file} MODULE ${ARGN})
    set_target_properties(plugin_${file} PROPERTIES OUTPUT_NAME ${file} C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden
                          VISIBILITY_INLINES_HIDDEN ON)
    # Variables of the same name in two plugins, or in two builds of one, stay apart.
    target_compile_options(plugin_${file} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
    jde_configure(plugin_${file})
endfunction()

# Builds a test on the bench from its sources, and adds it to ctest.
function(jde_add_test NAME)
    add_executable(test_${NAME} ${ARGN})
    jde_configure(test_${NAME})
    add_test(NAME ${NAME} COMMAND test_${NAME})
endfunction()

function(jde_configure TARGET)
    target_link_libraries(${TARGET} PRIVATE jde::jde)
    target_compile_options(${TARGET} PRIVATE -Wall -Wextra)
    if(CMAKE_CXX_COMPILER)
        target_compile_features(${TARGET} PRIVATE cxx_std_17)
    endif()
endfunction()
